//! What a caller asks for of Tikhonov regularisation.

use super::criterion::Parameter;

/// `min ‖Y − XA‖² + λ P(A)`, P being the roughness of the fitted function.
///
/// For polynomials and B-splines `P = w_u ∫∫ (∂ᵏf/∂uᵏ)² + w_v ∫∫ (∂ᵏf/∂vᵏ)²` over the domain, in
/// the caller's units; for a curve the first term alone. For a linear model, whose columns are no
/// functions, `P = w Σ (Δᵏ A)²`, the squared differences of order k of neighbouring coefficients in
/// the order of the columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Tikhonov {
    /// k, from 0 to 3.
    pub order: usize,
    /// `[w_u, w_v]` (`[w]` for a curve or a linear model), none negative, one positive; by default
    /// all 1.
    pub weights: Option<Vec<f64>>,
    /// λ.
    pub parameter: Parameter,
}
