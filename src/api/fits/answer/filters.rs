//! What filters changed, in a fit's answer.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::declare::{FieldsAs, ListAs, Name, WriteAs, answer};
use crate::api::json::writer::Object;
use flankfit_engine::estimation::{
    result::{ColumnFigures, FilterReport, FilteringReport},
    spec::{Filter, Include},
};

answer! {
    /// Changes by one filter.
    pub struct FilterResult from FilterReport as report {
        filter, changed, max_change, rms_change, peaks, iteration,
    } with include {
        kind as "type": FilterName = Name(filter_name(filter)),
        /// Number of nodes whose height was changed or that were removed.
        changed: usize = changed,
        /// Number of nodes removed.
        removed: usize = report.removed(),
        /// Largest change of a height; of a removed node its distance from the median of its
        /// window.
        max_change: f64 = max_change,
        /// Root mean square of the changes, over the nodes that counted before this filter.
        rms_change: f64 = rms_change,
        /// Posted nodes (from 0, grids row by row) that were taken for peaks; of `hampel` only,
        /// present when `peaks` was included.
        node_indices?: Vec<usize> = peaks.as_ref().filter(|_| include.peaks),
        /// Rounds of the line that took the most; of a robust filter only.
        iterations?: usize = iteration.as_ref().map(|report| report.iterations),
        /// True if the iteration converged on every line; for a robust filter only.
        converged?: bool = iteration.as_ref().map(|report| report.converged),
    }
}

answer! {
    /// Linear dependence of the columns before and after the filters, which may smooth away the
    /// difference between terms. `after` is that of the filtered matrix X without removed nodes,
    /// with the peaks and robustness weights found from the heights; the fit itself relates the
    /// filtered heights to X.
    pub struct FilterCollinearity from FilteringReport { filters: _, before, after } {
        before: ColumnFiguresBody = before,
        after: ColumnFiguresBody = after,
    }
}

answer! {
    /// Figures of a measurement matrix.
    #[schema(as = ColumnFigures)]
    pub struct ColumnFiguresBody from ColumnFigures { nodes, condition, largest_correlation, largest_vif } {
        /// Counted nodes.
        count: usize = nodes,
        /// λₙ/λ₁ on columns of unit length; absent when it cannot be given.
        condition?: f64 = condition,
        /// Largest |Pearson correlation| of two columns.
        largest_correlation?: f64 = largest_correlation,
        /// Largest variance inflation factor.
        largest_vif?: f64 = largest_vif,
    }
}

/// Which filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum FilterName {
    Hampel,
    Gaussian,
    Spline,
}

fn filter_name(filter: &Filter) -> &'static str {
    match filter {
        Filter::Hampel(_) => "hampel",
        Filter::Gaussian(_) => "gaussian",
        Filter::Spline(_) => "spline",
    }
}
