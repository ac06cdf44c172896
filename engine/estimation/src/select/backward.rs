//! Backward elimination: from all terms on, that one goes whose loss raises the residual sum of
//! squares least.
//!
//! Of the models with one term less this is the best by every criterion that rests on RSS and the
//! number of terms, and the same in every basis: only terms that divide no other may go. All steps
//! are made; the criterion then chooses among the models on the way.

use super::{problem::Problem, terms::Hierarchy};
use crate::result::Candidate;
use flankfit_numerics::cancel::Asking;

/// The models on the way, by columns.
pub(super) fn path(problem: &Problem, hierarchy: &Hierarchy, size: usize) -> Vec<(Vec<usize>, Candidate)> {
    let mut columns: Vec<usize> = (0..size).collect();
    let mut found = Vec::with_capacity(size);
    for _ in (0..size).asking(size * size * size) {
        let subspace = problem.triangle.subspace(&columns);
        found.push((columns.clone(), problem.figures(&subspace)));
        let least = (0..columns.len())
            .filter(|&at| hierarchy.may_go(&columns, at))
            .min_by(|&x, &y| subspace.rises[x].total_cmp(&subspace.rises[y]));
        let Some(at) = least else { break };
        columns.remove(at);
    }
    found
}
