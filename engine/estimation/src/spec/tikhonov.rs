//! Settings of Tikhonov regularisation.

use super::criterion::Parameter;

/// The highest order of derivatives that a penalty may have.
pub const HIGHEST_ORDER: usize = 3;

/// `min ‖Y − XA‖² + λ P(A)`, P being the roughness of the fitted function.
///
/// For polynomials and B-splines `P = w_u ∫∫ (∂ᵏf/∂uᵏ)² + w_v ∫∫ (∂ᵏf/∂vᵏ)²` over the domain, in
/// the caller's units; for a curve the first term alone. For a linear model, whose columns are no
/// functions, `P = w Σ (Δᵏ A)²`, the squared differences of order k of neighbouring coefficients in
/// the order of the columns.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Degree, Knots, Model, Parameter, Regularization, Tikhonov},
/// };
///
/// // A rough line. With ever more weight on ∫ (f″)² a spline becomes the straight line of least
/// // squares.
/// let x: Vec<f64> = (0..=10).map(f64::from).collect();
/// let y = [0.3, 0.9, 2.2, 2.8, 4.1, 5.2, 5.7, 7.3, 7.9, 8.8, 10.2];
/// let nodes = Nodes::curve(x.clone(), y.to_vec(), None)?;
/// let model = Model::BSpline { degree: Degree::Both(3), knots: Knots::Spans(4), weights: None };
/// let penalty = Tikhonov { order: 2, weights: None, parameter: Parameter::Fixed(1e9) };
/// let found = fit(
///     &nodes,
///     &FitSpec { regularization: Regularization::Tikhonov(penalty), ..FitSpec::new(model) },
/// )?;
///
/// let mean = |values: &[f64]| values.iter().sum::<f64>() / 11.0;
/// let slope = x.iter().zip(&y).map(|(x, y)| (x - 5.0) * y).sum::<f64>() / 110.0;
/// // Control points of the line stand at the Greville abscissae 0, 5/6, 15/6, …, 10.
/// let first = mean(&y) - 5.0 * slope;
/// assert!((found.coefficients[0].value - first).abs() < 1e-5);
/// assert!((found.coefficients[6].value - (first + 10.0 * slope)).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
