//! Conditions on the shape of a fitted curve or surface.

use super::{filter::FilterAxis, model::Domain};

/// A condition on the shape of the fitted curve or surface. It holds everywhere in its domain, not
/// only at the nodes.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{
///         Constraint, ConstraintKind, Degree, Model, Places, PolynomialBasis, Predict,
///         Regularization, Terms,
///     },
/// };
///
/// // Wear that only grows, read with errors: the plain cubic falls at its beginning.
/// let x: Vec<f64> = (0..10).map(f64::from).collect();
/// let y = vec![1.0, 0.2, 0.9, 0.3, 0.8, 0.6, 1.9, 3.3, 5.8, 9.1];
/// let nodes = Nodes::curve(x, y, None)?;
/// let model = Model::Polynomial {
///     degree: Degree::Both(3),
///     basis: PolynomialBasis::Chebyshev,
///     terms: Terms::Tensor,
/// };
/// let at = Places::Curve((0..=90).map(|k| f64::from(k) / 10.0).collect());
/// let plain = FitSpec {
///     regularization: Regularization::None,
///     predict: Some(Predict { at, level: None, kinds: Default::default(), slopes: true }),
///     ..FitSpec::new(model)
/// };
/// let least_slope = |spec: &FitSpec| {
///     let found = fit(&nodes, spec)?.predictions.expect("places were given");
///     let slopes = found.slope_u.expect("slopes were asked for").value;
///     Ok::<f64, flankfit_estimation::FitError>(slopes.into_iter().fold(f64::INFINITY, f64::min))
/// };
/// assert!(least_slope(&plain)? < -0.1);
///
/// let growing = Constraint { kind: ConstraintKind::Increasing, along: None, domain: None };
/// let constrained = FitSpec { constraints: vec![growing], ..plain };
/// assert!(least_slope(&constrained)? >= 0.0);
/// // It is the best of all cubics that grow, to the rounding of doubles and a little more.
/// let report = fit(&nodes, &constrained)?.constraints.expect("there are some");
/// assert!(report.rss - report.rss_bound < 1e-6 * report.rss);
/// assert!(report.constraints[0].least_value >= 0.0 && !report.constraints[0].active.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(deny_unknown_fields),
    schema(example = json!({"kind": "concave", "along": "v"}))
)]
pub struct Constraint {
    /// Shape of the function.
    pub kind: ConstraintKind,
    /// The axis along which the function rises, falls or bends. A surface needs it; a curve has
    /// only `u`, its x.
    #[cfg_attr(feature = "contract", serde(skip_serializing_if = "Option::is_none"))]
    pub along: Option<FilterAxis>,
    /// Range in which the constraint applies, within the domain of the fit; default the whole
    /// domain. Opposite constraints along an axis must not touch.
    #[cfg_attr(feature = "contract", serde(skip_serializing_if = "Option::is_none"))]
    pub domain: Option<Domain>,
}

/// Shape along the axis: `increasing` and `decreasing` limit the first derivative, which may be 0;
/// `convex` and `concave` limit the second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum ConstraintKind {
    /// Its slope is nowhere negative.
    Increasing,
    /// Its slope is nowhere positive.
    Decreasing,
    /// Its second derivative is nowhere negative.
    Convex,
    /// Its second derivative is nowhere positive.
    Concave,
}

impl ConstraintKind {
    /// Order of the derivative that it is about.
    pub fn order(self) -> usize {
        match self {
            ConstraintKind::Increasing | ConstraintKind::Decreasing => 1,
            ConstraintKind::Convex | ConstraintKind::Concave => 2,
        }
    }

    /// Sign that the derivative must not have the opposite of.
    pub fn sign(self) -> f64 {
        match self {
            ConstraintKind::Increasing | ConstraintKind::Convex => 1.0,
            ConstraintKind::Decreasing | ConstraintKind::Concave => -1.0,
        }
    }
}
