//! Sums over past nodes, which a stream keeps with R and Qᵀy.

use flankfit_numerics::Dd;

/// Sizes do not grow with the nodes seen.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SummaryStatistics {
    /// Counted nodes.
    pub count: usize,
    /// `Σ w r²` of the least-squares residuals, the part that the columns cannot reach.
    pub rss: Dd,
    /// True if some height may be the rounding of a decimal fraction.
    pub rounded_heights: bool,
    /// Largest |u| and |v| that may have been rounded.
    pub rounded_places: [f64; 2],
    /// Smallest and largest u and v.
    pub bounds: [[f64; 2]; 2],
    /// For a measurement matrix, by column: the largest `√w |x|` that may have been rounded.
    pub rounded_columns: Vec<f64>,
    /// `Σ w ((∂x/∂u)² + (∂x/∂v)²)` of the caller's columns.
    pub slopes: Vec<f64>,
}
