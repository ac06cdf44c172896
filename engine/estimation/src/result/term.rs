//! Coefficients and how they are addressed.

use super::interval::Interval;

/// Address of a coefficient: exactly one of the three.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum TermKey {
    /// Degrees of a polynomial term: one for a curve, two for a surface.
    #[cfg_attr(feature = "contract", schema(example = json!([2, 1])))]
    Powers(Vec<usize>),
    /// Indices of a B-spline, from 0: one for a curve, two for a surface.
    Index(Vec<usize>),
    /// Column of a measurement matrix, from 0.
    Column(usize),
}

/// One coefficient; exactly one of `powers`, `index` and `column` is there.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Coefficient {
    /// Readable name.
    #[cfg_attr(feature = "contract", schema(example = "u^2*v"))]
    pub term: String,
    /// The same as data.
    #[cfg_attr(feature = "contract", serde(flatten))]
    pub key: TermKey,
    /// The regularised estimate Â_B (Eq. 29) by the chosen estimator. With a `prior` the mean
    /// of the posterior; with `constraints` the best estimate that meets them.
    pub value: f64,
    /// Standard error of `value` where λ* was given or the fit is not regularised, and of
    /// `least_squares` where λ* was chosen from the nodes. In simulations of one flank the truth
    /// lay within one standard error of least squares in 66 to 70 % of the cases
    /// (docs/explanation/mathematics.md). Absent without degrees of freedom. With a `prior` the
    /// standard deviation of the posterior, by `prior.sigma`. With `constraints` that of least
    /// squares with the derivatives at the active places held at 0, as if these places had been
    /// known in advance: too small (docs/explanation/constraints.md).
    pub std_error: Option<f64>,
    /// Standard error of `value` for the λ* used, as if λ* had not been chosen from the same nodes;
    /// present where it was and `std_error` differs. It is too small and excludes the bias: it
    /// contained the truth in 23 to 44 % of the cases, not 68 %.
    pub conditional_std_error: Option<f64>,
    /// Plain least-squares estimate from the posted nodes, whatever the estimator.
    pub least_squares: f64,
    /// Standard error of `least_squares`.
    pub least_squares_std_error: Option<f64>,
    /// Sharp bound on the bias |Â − Â_B| of this coefficient for norm limit r. With a `prior`
    /// that of the posterior mean, for coefficients as far from the prior mean as its
    /// covariance P implies on average (eᵀP⁻¹e ≤ n). With `constraints` √n standard errors of
    /// least squares, which bound the bias for every truth that meets the constraints.
    pub bias_bound: f64,
    /// Confidence interval; `None` without an estimate of the noise, and where the coefficient is
    /// not bounded.
    #[cfg_attr(feature = "contract", serde(flatten))]
    pub interval: Option<Interval>,
}

impl Coefficient {
    /// Returns the standard error of `value` conditional on the λ* used, whether given or selected.
    pub fn error_given_lambda(&self) -> Option<f64> {
        self.conditional_std_error.or(self.std_error)
    }
}
