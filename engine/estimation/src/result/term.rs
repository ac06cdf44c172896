//! Coefficients and how they are addressed.

use super::interval::Interval;

/// How a coefficient is addressed: exactly one of the three.
#[derive(Clone, Debug, PartialEq)]
pub enum TermKey {
    /// Polynomial degrees: `[p]` for a curve, `[p, q]` for a surface.
    Powers(Vec<usize>),
    /// B-spline indices, from 0.
    Index(Vec<usize>),
    /// Column of a measurement matrix, from 0.
    Column(usize),
}

/// An estimated coefficient, with its errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficient {
    /// Readable name: `u^2*v`, `T2(u)*T1(v)`, `B3(u)*B0(v)`, or the column's name.
    pub term: String,
    /// The same as data.
    pub key: TermKey,
    /// Regularised estimate Â_B (Eq. 29).
    pub value: f64,
    /// Valid standard error; `None` without degrees of freedom. It is that of `value` if λ* was
    /// given, and that of `least_squares` if λ* was selected from the heights, since this selection
    /// makes [`Coefficient::conditional_std_error`] too small. It does not include the bias.
    pub std_error: Option<f64>,
    /// Standard error of `value` conditional on the λ* used; present if λ* was selected from the
    /// heights.
    pub conditional_std_error: Option<f64>,
    /// Least-squares estimate Â (Eq. 15).
    pub least_squares: f64,
    /// Standard error of `least_squares`; `None` without degrees of freedom.
    pub least_squares_std_error: Option<f64>,
    /// Sharp bound on |Â − Â_B| of this coefficient, given r.
    pub bias_bound: f64,
    /// Confidence interval of the coefficient; `None` without an estimate of the noise, and where
    /// nodes and norm limit leave it free.
    pub interval: Option<Interval>,
}

impl Coefficient {
    /// Returns the standard error of `value` conditional on the λ* used, whether given or selected.
    pub fn error_given_lambda(&self) -> Option<f64> {
        self.conditional_std_error.or(self.std_error)
    }
}
