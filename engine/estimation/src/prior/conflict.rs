//! Test of the nodes against the prior.
//!
//! `eᵀS⁻¹e/n` against F(n, ν), with the moves as large as the jumps **before** say: the jump that
//! is judged has no part in it. Few jumps leave much open, so the probability is the mean over all
//! sizes of the moves, not that at the likeliest: of flanks that always move evenly two in 5,000 at
//! most are dropped after six iterations (docs/explanation/prior.md), by the likeliest size it
//! would be several times as many.

use super::chain::{Branch, weights};
use crate::result::PriorConflict;
use flankfit_numerics::distribution::fisher;

/// Probabilities below which a prior is dropped.
const IMPROBABLE: f64 = 1e-4;

/// Denominators of F above which it is chi squared.
const MOST_FREEDOM: f64 = 1e9;

/// Compares the nodes of now with the branches; `freedom` is that of σ̂, `None` for a given σ.
pub(super) fn conflict(branches: &[Branch], freedom: Option<usize>) -> PriorConflict {
    let weights = weights(branches.iter().map(|branch| branch.ln_earlier));
    let freedom = freedom.map_or(MOST_FREEDOM, |freedom| freedom as f64);
    let (mut statistic, mut p) = (0.0, 0.0);
    for (branch, weight) in branches.iter().zip(weights) {
        let n = branch.posterior.size() as f64;
        statistic += weight * branch.distance / n;
        p += weight * fisher::upper_tail(branch.distance / n, n, freedom);
    }
    PriorConflict { statistic, p, dropped: p < IMPROBABLE }
}
