//! Settings of shrinkage to a target.

use super::criterion::Parameter;

/// `Â_JS = T + c (Â − T)` with a factor c that the data give.
///
/// With `Q = ‖X(Â − T)‖²`, p directions, RSS on ν degrees of freedom; where σ is given
/// (`noise_sigma`) its square takes the place of the estimate of the variance.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{JamesStein, Model, Regularization, ShrinkageFactor},
/// };
///
/// let rows =
///     (0..8).flat_map(|k| [1, 2, 4].map(|bit| if k & bit == 0 { 1.0 } else { -1.0 })).collect();
/// let heights = vec![1.2, 0.1, 0.7, -0.6, 0.9, -0.3, 0.2, -1.1];
/// let squares: f64 = heights.iter().map(|y| y * y).sum();
/// let nodes = Nodes::matrix(rows, 3, heights, None, None)?;
/// let shrunk =
///     JamesStein { factor: ShrinkageFactor::JamesStein, positive_part: true, target: None };
/// let found = fit(
///     &nodes,
///     &FitSpec {
///         regularization: Regularization::JamesStein(shrunk),
///         ..FitSpec::new(Model::Linear)
///     },
/// )?;
///
/// // c = 1 − (p − 2) RSS/((ν + 2) ‖XÂ‖²) with p = 3 columns and ν = 5 degrees of freedom.
/// let rss = found.residuals.least_squares_rss;
/// let c = 1.0 - rss / (7.0 * (squares - rss));
/// assert!(found.regularization.shrinkage_factor.is_some_and(|factor| (factor - c).abs() < 1e-14));
/// for coefficient in &found.coefficients {
///     assert!((coefficient.value - c * coefficient.least_squares).abs() < 1e-14);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct JamesStein {
    /// Formula of the factor c.
    pub factor: ShrinkageFactor,
    /// c is not let below 0.
    pub positive_part: bool,
    /// T in the caller's terms; 0 where none is given (but see [`ShrinkageFactor::EfronMorris`]).
    pub target: Option<Vec<f64>>,
}

/// The factor c.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShrinkageFactor {
    /// `1 − (p−2) RSS/((ν+2) Q)`: James and Stein with unknown variance, the least risk of this
    /// form.
    JamesStein,
    /// `1 − (p−2) s²/Q`, `s² = RSS/ν`.
    HoerlKennard,
    /// Variant of [`ShrinkageFactor::JamesStein`] in which without a target T is the grand mean:
    /// the constant function of the (weighted) mean height, which costs one direction (p−3 in place
    /// of p−2), as Efron and Morris did.
    EfronMorris,
}

/// `Â = (Â + kT)/(1 + k)`, which minimises `‖Y − XA‖² + k ‖X(A − T)‖²`.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Attraction, Model, Parameter, Regularization},
/// };
///
/// // With k = 1 the estimate is half-way between least squares and the coefficients of before.
/// let nodes =
///     Nodes::matrix(vec![1.0, 0.0, 1.0, 1.0, 1.0, 2.0], 2, vec![0.0, 1.0, 3.0], None, None)?;
/// let attraction = Attraction { target: vec![1.0, 1.0], parameter: Parameter::Fixed(1.0) };
/// let found = fit(
///     &nodes,
///     &FitSpec {
///         regularization: Regularization::Attraction(attraction),
///         ..FitSpec::new(Model::Linear)
///     },
/// )?;
/// for coefficient in &found.coefficients {
///     assert!((coefficient.value - (coefficient.least_squares + 1.0) / 2.0).abs() < 1e-14);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Attraction {
    /// T in the caller's terms.
    pub target: Vec<f64>,
    /// k.
    pub parameter: Parameter,
}
