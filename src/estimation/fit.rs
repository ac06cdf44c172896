//! The way of a fit.

use super::{error::FitError, nodes::Nodes, result::FitResult, spec::FitSpec};

/// Fits `spec` to `nodes`. Pure: no clock, no randomness, no state; the same input gives the same bits.
pub fn fit(_nodes: &Nodes, _spec: &FitSpec) -> Result<FitResult, FitError> {
    Err(FitError::NotConverged("under construction"))
}
