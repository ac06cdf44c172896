//! Faults of a fit that is made for a shape, with their places in the request.

use crate::api::{faults::moved, problem::Problem};
use flankfit_engine::estimation::FitError;

/// The pointer of a path of the fit, whose nodes stand at `base` and whose model is the method.
pub fn of_fit(path: &str, base: &str) -> String {
    moved(path, &[("nodes", base), ("model", "/method")])
}

/// A fit of a shape that was refused.
pub fn refused(error: FitError, base: &str) -> Problem {
    Problem::of_fit(error, |path| of_fit(path, base))
}
