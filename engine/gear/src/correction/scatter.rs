//! Errors of means over teeth; [`super::teeth`] estimates them.

/// Covariance of the errors of means over teeth, of all flanks one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scatter {
    /// Vectors e, µm for each node; Σ e eᵀ is the covariance that the scatter of teeth leaves in
    /// the means.
    pub columns: Vec<Vec<f64>>,
    /// Degrees of freedom of each of them, of the flank that has fewest; 0 where the scatter is not
    /// known.
    pub freedom: usize,
    /// Standard error of a mean at a node of weight 1, µm; 0 where it is not known.
    pub node: f64,
}
