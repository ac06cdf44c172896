//! Application of a prior to a fit.

use std::sync::Arc;

use crate::{
    prior::{FormIntervals, PooledNoise},
    result::PriorReport,
};

/// Results of a prior in a fit.
pub(crate) struct PriorApplied {
    pub report: PriorReport,
    /// The noise by which the posterior was weighed; `None` where there is no posterior.
    pub noise: Option<PooledNoise>,
    /// Parts of the intervals, if moves were estimated, also if the prior was dropped.
    pub intervals: Option<Arc<FormIntervals>>,
}
