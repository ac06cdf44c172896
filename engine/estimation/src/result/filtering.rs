//! Report on filters.

use crate::spec::{Action, Filter};

/// Everything about the filters of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct FilteringReport {
    /// One for each filter, in the order applied.
    pub filters: Vec<FilterReport>,
    /// Figures of the functions at the posted nodes.
    pub before: ColumnFigures,
    /// Figures of the same functions after the same filters.
    pub after: ColumnFigures,
}

/// What one filter changed.
#[derive(Clone, Debug, PartialEq)]
pub struct FilterReport {
    /// The filter as asked for.
    pub filter: Filter,
    /// Nodes whose height is another one now, or that were removed.
    pub changed: usize,
    /// Largest change of a height; of a removed node its distance from the median of its window.
    pub max_change: f64,
    /// √(Σ change²/m) over the m nodes that counted before this filter.
    pub rms_change: f64,
    /// Posted nodes that were taken for peaks, ascending; of a Hampel filter only.
    pub peaks: Option<Vec<usize>>,
    /// Iteration of a robust Gaussian filter only.
    pub iteration: Option<IterationReport>,
}

impl FilterReport {
    /// Nodes that count no more.
    pub fn removed(&self) -> usize {
        match self.filter {
            Filter::Hampel(hampel) if hampel.action == Action::Remove => self.changed,
            _ => 0,
        }
    }
}

/// How the iteration of a robust filter ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IterationReport {
    /// Rounds of the line that took the most.
    pub iterations: usize,
    /// Whether every line came to rest within the rounds allowed.
    pub converged: bool,
}

/// How the columns depend on each other; a number that does not exist is `None`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ColumnFigures {
    /// Counted nodes.
    pub nodes: usize,
    /// λₙ/λ₁ of the Fisher information matrix on columns of unit length.
    pub condition: Option<f64>,
    /// Largest |Pearson correlation| of two columns that vary.
    pub largest_correlation: Option<f64>,
    /// Largest variance inflation factor.
    pub largest_vif: Option<f64>,
}
