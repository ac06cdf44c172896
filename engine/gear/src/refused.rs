//! Reasons why something that is made by a fit is refused.

use flankfit_estimation::FitError;
use flankfit_numerics::check::Faults;

/// Why something that is made by a fit is refused: by checks of its own, or by the fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refused {
    /// Something in what was asked for is impossible.
    #[error(transparent)]
    Invalid(#[from] Faults),
    /// The fit was refused.
    #[error(transparent)]
    Fit(#[from] FitError),
}
