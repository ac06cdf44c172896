//! Result of a model of the errors.

use crate::spec::{Along, Correlation};

/// Errors that are correlated along scan lines.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorsReport {
    /// The correlation, with the parameters that were told or estimated.
    pub correlation: Correlation,
    /// Which way lines run.
    pub along: Along,
    /// Standard errors of the parameters, where they were estimated: of one or of two.
    pub std_errors: Option<[f64; 2]>,
    /// So many independent heights would tell as much of a mean.
    pub effective_count: f64,
    /// Whiteness of the residuals of plain least squares, and of the whitened ones; `None` where
    /// all are 0, also but for rounding, or no line has two nodes.
    pub whiteness: Option<[Whiteness; 2]>,
    /// Lags of Ljung and Box's figure.
    pub lags: usize,
}

/// Variances that were estimated.
#[derive(Clone, Debug, PartialEq)]
pub enum VarianceReport {
    /// Groups: name, standard deviation of a height of weight 1.
    Groups(Vec<(i64, f64)>),
    /// The power.
    Power {
        /// Exponent of the coordinate.
        exponent: f64,
        /// Where a height of weight 1 has the standard deviation `sigma` of the residuals.
        at: f64,
    },
}

/// Both figures of residuals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whiteness {
    /// The mean of `(rᵢ − rᵢ₊₁)²` over neighbours on one line over the mean of r² over the nodes:
    /// about 2 for white residuals, whatever the number of lines.
    pub durbin_watson: f64,
    /// `m(m + 2) Σ cₕ²/mₕ` over lags h, cₕ being `Σ rᵢrᵢ₊ₕ/Σ r²` over the mₕ pairs of lag h.
    pub ljung_box: f64,
    /// P(χ² > Q) of as many degrees of freedom as lags.
    pub ljung_box_p: f64,
}

impl ErrorsReport {
    pub(crate) fn is_finite(&self) -> bool {
        let whiteness = self.whiteness.iter().flatten();
        let tests = whiteness.flat_map(|found| [found.durbin_watson, found.ljung_box, found.ljung_box_p]);
        tests.chain(self.std_errors.iter().flatten().copied()).chain([self.effective_count]).all(f64::is_finite)
    }
}

impl VarianceReport {
    pub(crate) fn is_finite(&self) -> bool {
        match self {
            VarianceReport::Groups(groups) => groups.iter().all(|(_, sigma)| sigma.is_finite()),
            VarianceReport::Power { exponent, at } => exponent.is_finite() && at.is_finite(),
        }
    }
}
