//! Application of a prior to a fit.

use std::sync::Arc;

use crate::{
    prior::{FormIntervals, PooledNoise},
    result::PriorReport,
};

/// What a prior adds to a fit.
pub(crate) struct PriorApplied {
    pub report: PriorReport,
    /// The noise by which the posterior was weighed; `None` where there is no posterior.
    pub noise: Option<PooledNoise>,
    /// What intervals are made of, where moves were estimated, whether or not the prior was let go.
    pub intervals: Option<Arc<FormIntervals>>,
}
