//! What a caller asks for of Tikhonov regularisation.

use super::criterion::Parameter;

/// The highest order of derivatives that a penalty may have.
pub const HIGHEST_ORDER: usize = 3;

/// `min ‖Y − XA‖² + λ P(A)`, P being the roughness of the fitted function.
///
/// For polynomials and B-splines `P = w_u ∫∫ (∂ᵏf/∂uᵏ)² + w_v ∫∫ (∂ᵏf/∂vᵏ)²` over the domain, in
/// the caller's units; for a curve the first term alone. For a linear model, whose columns are no
/// functions, `P = w Σ (Δᵏ A)²`, the squared differences of order k of neighbouring coefficients in
/// the order of the columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Tikhonov {
    /// k, up to [`HIGHEST_ORDER`].
    pub order: usize,
    /// `[w_u, w_v]` (`[w]` for a curve or a linear model), none negative, one positive; by default
    /// all 1.
    pub weights: Option<Vec<f64>>,
    /// λ.
    pub parameter: Parameter,
}
