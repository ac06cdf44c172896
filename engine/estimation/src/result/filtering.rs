//! Report on filters.

use crate::spec::Filter;

/// Linear dependence of the columns before and after the filters, which may smooth away the
/// difference between terms. `after` is that of the filtered matrix X without removed nodes,
/// with the peaks and robustness weights found from the heights; the fit itself relates the
/// filtered heights to X.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct FilterCollinearity {
    /// Figures of the functions at the posted nodes.
    pub before: ColumnResults,
    /// Figures of the same functions after the same filters.
    pub after: ColumnResults,
}

/// Changes by one filter.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = FilterResult)
)]
pub struct FilterReport {
    /// Type of the filter.
    #[cfg_attr(feature = "contract", serde(rename = "type"))]
    pub kind: FilterKind,
    /// Number of nodes whose height was changed or that were removed.
    pub changed: usize,
    /// Number of nodes removed.
    pub removed: usize,
    /// Largest change of a height; of a removed node its distance from the median of its
    /// window.
    pub max_change: f64,
    /// Root mean square of the changes, over the nodes that counted before this filter.
    pub rms_change: f64,
    /// Posted nodes (from 0, grids row by row) that were identified as peaks; for `hampel` only,
    /// present when `peaks` was included.
    pub node_indices: Option<Vec<usize>>,
    /// Iteration of a robust filter.
    #[cfg_attr(feature = "contract", serde(flatten))]
    pub iteration: Option<IterationReport>,
}

/// Type of a filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = FilterName)
)]
pub enum FilterKind {
    /// Filter of peaks by the median of a window.
    Hampel,
    /// Gaussian filter.
    Gaussian,
    /// Spline filter.
    Spline,
}

impl From<&Filter> for FilterKind {
    fn from(filter: &Filter) -> Self {
        match filter {
            Filter::Hampel(_) => FilterKind::Hampel,
            Filter::Gaussian(_) => FilterKind::Gaussian,
            Filter::Spline(_) => FilterKind::Spline,
        }
    }
}

/// End of the iteration of a robust filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct IterationReport {
    /// Rounds of the line that took the most; of a robust filter only.
    pub iterations: usize,
    /// True if the iteration converged on every line; for a robust filter only.
    pub converged: bool,
}

/// Figures of a measurement matrix.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct ColumnResults {
    /// Counted nodes.
    #[cfg_attr(feature = "contract", serde(rename = "count"))]
    pub nodes: usize,
    /// λₙ/λ₁ on columns of unit length; absent if it is not available.
    pub condition: Option<f64>,
    /// Largest |Pearson correlation| of two columns.
    pub largest_correlation: Option<f64>,
    /// Largest variance inflation factor.
    pub largest_vif: Option<f64>,
}
