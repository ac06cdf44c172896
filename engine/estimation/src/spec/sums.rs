//! Sums over the fitted curve or surface.

/// Weighted sums of the heights of the fitted curve or surface at places of its domain, in the
/// caller's unit. Every linear functional of the fitted function that a quadrature gives is one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WeightedSums {
    /// u and v of each place; v is not looked at for a curve.
    pub places: Vec<[f64; 2]>,
    /// For each sum a weight for each place.
    pub weights: Vec<Vec<f64>>,
}
