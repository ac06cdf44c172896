//! Residuals.

/// Residuals Y − X Â_B.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = Residuals)
)]
pub struct ResidualReport {
    /// Nodes counted.
    pub count: usize,
    /// Nodes counted less coefficients; with a forgetting factor their effective number is counted.
    pub degrees_of_freedom: usize,
    /// Σ w r² of the regularised estimate.
    pub rss: f64,
    /// σ̂ of the plain least-squares fit; absent without degrees of freedom.
    pub sigma: Option<f64>,
    /// √(Σ w r² / Σ w), in the unit of the heights.
    pub rms: f64,
    /// Largest |residual|; absent for a stream, which keeps no nodes.
    pub max_abs: Option<f64>,
    /// About the mean when the constant lies in the span of the columns, about 0 otherwise.
    pub r_squared: Option<f64>,
    /// Σ w r² of the plain least-squares fit.
    pub least_squares_rss: f64,
    /// One per counted node, in the order posted; present when `residuals` was included.
    pub values: Option<Vec<f64>>,
    /// The fitted function at each counted node, in the order posted; present when `fitted` was
    /// included.
    pub fitted: Option<Vec<f64>>,
    /// The height that was fitted of each counted node; present with `fitted` where filters
    /// changed some height.
    pub heights: Option<Vec<f64>>,
    /// The posted node (from 0, grids row by row) of each number of the lists above; present with
    /// them if some node was omitted.
    pub node_indices: Option<Vec<usize>>,
}
