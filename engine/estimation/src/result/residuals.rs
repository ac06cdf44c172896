//! Residuals.

/// What the fitted function leaves of the heights.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualReport {
    /// Nodes counted (missing ones and those of weight 0 are not).
    pub count: usize,
    /// m − n: counted nodes less coefficients.
    pub degrees_of_freedom: usize,
    /// Σ w r² of the regularised estimate.
    pub rss: f64,
    /// σ̂ of the least-squares residuals; `None` without degrees of freedom.
    pub sigma: Option<f64>,
    /// √(Σ w r² / Σ w).
    pub rms: f64,
    /// `None` where the nodes are gone (a stream keeps sums only).
    pub max_abs: Option<f64>,
    /// 1 − RSS over the sum of squares about the mean (about 0 where the columns do not span a
    /// constant); `None` where that sum is 0.
    pub r_squared: Option<f64>,
    /// Σ w r² of the least-squares estimate.
    pub least_squares_rss: f64,
    /// One per counted node, in the order posted (grids row by row); present when included.
    pub values: Option<Vec<f64>>,
    /// The fitted heights, one per counted node; present when included.
    pub fitted: Option<Vec<f64>>,
    /// The heights that were fitted, one per counted node; present with `fitted` where filters
    /// changed them.
    pub heights: Option<Vec<f64>>,
    /// Which posted node each value belongs to; present with the lists above when some node was
    /// left out.
    pub node_indices: Option<Vec<usize>>,
}
