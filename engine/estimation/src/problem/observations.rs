//! Observations after the factorisation: all nodes for a fit of posted nodes, sums for a stream.

use super::summary::SummaryStatistics;
use crate::{
    data::{Nodes, Sample},
    design::{Design, slopes},
    spectrum::{ScaledColumns, of_scaled},
};

/// Nodes, or what is left of them.
#[derive(Clone, Copy)]
pub(crate) enum Evidence<'a> {
    Posted { sample: &'a Sample<'a>, nodes: &'a Nodes },
    Summed(&'a SummaryStatistics),
}

impl Evidence<'_> {
    /// m, the number of counted nodes.
    pub(crate) fn count(&self) -> usize {
        match self {
            Evidence::Posted { sample, .. } => sample.count(),
            Evidence::Summed(summary) => summary.count,
        }
    }

    /// Indices of the posted nodes that count; `None` if all do or the nodes are not kept.
    pub(crate) fn counted(&self) -> Option<&[u32]> {
        match self {
            Evidence::Posted { sample, .. } => sample.index(),
            Evidence::Summed(_) => None,
        }
    }

    /// `Σ w ((∂x̃/∂u)² + (∂x̃/∂v)²)` over nodes and scaled columns.
    pub(crate) fn slopes(&self, design: &Design, columns: &ScaledColumns) -> f64 {
        match self {
            Evidence::Posted { sample, .. } => of_scaled(&slopes(design, sample), columns),
            Evidence::Summed(summary) => of_scaled(&summary.slopes, columns),
        }
    }
}
