//! What a prior adds to a fit.

use crate::estimation::{prior::PooledNoise, result::PriorReport};

/// What a prior adds to a fit.
pub(crate) struct PriorApplied {
    pub report: PriorReport,
    /// The noise by which the posterior was weighed; `None` where there is no posterior.
    pub noise: Option<PooledNoise>,
}
