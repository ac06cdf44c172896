//! Everything about a fit but the nodes.

use std::sync::Arc;

use super::{
    constraint::Constraint,
    criterion::Criterion,
    errors::{Errors, Variance},
    estimator::Estimator,
    filter::Filter,
    folds::Folds,
    model::{Domain, Model, Scaling},
    node_at::NodeAt,
    predict::Predict,
    prior::{Earlier, Prior},
    regularization::Regularization,
    select::Select,
    sums::WeightedSums,
};

/// Level of confidence intervals where none is given.
pub const DEFAULT_LEVEL: f64 = 0.95;

/// Everything about a fit but the nodes.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Model, Regularization},
/// };
///
/// // Two settings of a machine that do nearly the same to three nodes.
/// let nodes =
///     Nodes::matrix(vec![1.0, 1.0, 2.0, 2.1, 3.0, 2.9], 2, vec![2.0, 4.2, 5.8], None, None)?;
/// let spec = FitSpec::new(Model::Linear);
/// let limit = |r: f64| FitSpec { coefficient_norm_limit: Some(r), ..spec.clone() };
///
/// // What regularisation can have moved is proportional to the norm r that coefficients may have.
/// let (near, far) = (fit(&nodes, &limit(10.0))?, fit(&nodes, &limit(20.0))?);
/// for (a, b) in near.coefficients.iter().zip(&far.coefficients) {
///     assert!(a.bias_bound > 0.0 && (b.bias_bound / a.bias_bound - 2.0).abs() < 1e-12);
/// }
/// // Without regularisation there is nothing to bound.
/// let plain = fit(&nodes, &FitSpec { regularization: Regularization::None, ..spec })?;
/// assert!(plain.coefficients.iter().all(|coefficient| coefficient.bias_bound == 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FitSpec {
    /// Functions whose mixture is fitted.
    pub model: Model,
    /// Scaling of the columns of X before the eigen analysis.
    pub scaling: Scaling,
    /// Regularisation and its parameter.
    pub regularization: Regularization,
    /// Estimator of the coefficients.
    pub estimator: Estimator,
    /// The box on which mapped bases live; by default the smallest box of the counted nodes.
    pub domain: Option<Domain>,
    /// `r ≥ ‖A‖` of Ineq. 51, in the scaled columns.
    pub coefficient_norm_limit: Option<f64>,
    /// Value of r if no limit is given.
    pub expected_size: ExpectedSize,
    /// Standard deviation of a height of weight 1; by default estimated from the residuals.
    pub noise_sigma: Option<f64>,
    /// Standard uncertainties of the nodes; with them perturbation bounds are returned.
    pub node_uncertainty: Option<NodeUncertainty>,
    /// Correlations of the errors; `None` where they are independent.
    pub errors: Option<Errors>,
    /// Variances of the errors in addition to the weights.
    pub variance: Variance,
    /// Level of confidence intervals, between 0.5 and 1.
    pub level: f64,
    /// Prior knowledge of the coefficients.
    pub prior: Option<Prior>,
    /// Constraints on the shape: the fitted function rises, falls or bends.
    pub constraints: Vec<Constraint>,
    /// Heights and bands at places of the domain.
    pub predict: Option<Predict>,
    /// Sums over the fitted curve or surface.
    pub sums: Option<WeightedSums>,
    /// Choice of one of several models, in place of `model` alone.
    pub select: Option<Select>,
    /// Nodes that blocked cross-validation leaves out together.
    pub folds: Option<Folds>,
    /// Parts of the response in addition to the default.
    pub include: Include,
    /// Filters applied to the nodes before the fit, in this order.
    pub filters: Vec<Filter>,
    /// Nodes excluded from the fit, as if they were missing.
    pub exclude: Vec<NodeAt>,
}

impl FitSpec {
    /// The defaults for a model: unit-length scaling, spectral / first_order / auto
    /// / min_mse, least squares.
    pub fn new(model: Model) -> Self {
        FitSpec {
            model,
            scaling: Scaling::UnitLength,
            regularization: Regularization::default(),
            estimator: Estimator::LeastSquares,
            domain: None,
            coefficient_norm_limit: None,
            expected_size: ExpectedSize::default(),
            noise_sigma: None,
            node_uncertainty: None,
            errors: None,
            variance: Variance::default(),
            level: DEFAULT_LEVEL,
            prior: None,
            constraints: Vec::new(),
            predict: None,
            sums: None,
            select: None,
            folds: None,
            include: Include::default(),
            filters: Vec::new(),
            exclude: Vec::new(),
        }
    }

    /// True if λ* is chosen by leaving out blocks of nodes.
    pub fn cross_validates(&self) -> bool {
        self.regularization.criterion() == Some(Criterion::BlockedCv)
    }

    /// The same with the earlier iterations of its prior; nothing changes where it has no chain.
    pub fn with_earlier(mut self, earlier: Arc<[Earlier]>) -> Self {
        if let Some(Prior::Iterations(chain)) = &mut self.prior {
            chain.earlier = Some(earlier);
        }
        self
    }
}

/// Assumed size of the coefficients. The estimate is the plain one, but along directions with small
/// eigenvalues it is mostly error. A λ* chosen because of that must not be judged by it: with
/// anything but [`ExpectedSize::Estimated`] the mean squared error about the estimate is no
/// yardstick, and no warning is derived from it.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum ExpectedSize {
    /// Size of the least-squares estimate: r = ‖Â‖.
    #[default]
    Estimated,
    /// Size that the heights suggest if all directions are alike: r = √n τ with τ² = ‖P y‖²/Σλᵢ, P
    /// y being the part of the heights that the columns reach; at least the norm of the regularised
    /// estimate.
    OfHeights,
    /// Within ± these, one for each coefficient in the caller's unit: r is the norm where all are
    /// reached; at least that of the regularised estimate.
    Within(Vec<f64>),
}

/// Standard uncertainties of a node, in the caller's unit.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Model, NodeUncertainty},
/// };
///
/// let rows = vec![1.0, 0.0, 1.0, 1.0, 1.0, 2.0, 1.0, 3.0];
/// let nodes = Nodes::matrix(rows, 2, vec![1.0, 3.1, 4.9, 7.0], None, None)?;
/// let bound = |uncertainty: f64| {
///     let (position, height) = (uncertainty, uncertainty);
///     let node_uncertainty = Some(NodeUncertainty { position, height, kind: None });
///     let found = fit(&nodes, &FitSpec { node_uncertainty, ..FitSpec::new(Model::Linear) })?;
///     let bounds = found.perturbation.expect("it was asked for").least_squares;
///     Ok::<f64, flankfit_estimation::FitError>(
///         bounds.first_order_bound.expect("the columns are independent"),
///     )
/// };
/// // Wedin's bound on the relative error of the coefficients is of first order.
/// assert!((bound(2e-6)? / bound(1e-6)? - 2.0).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(deny_unknown_fields)
)]
pub struct NodeUncertainty {
    /// Standard uncertainty of each abscissa (of each entry of a measurement matrix).
    #[cfg_attr(feature = "contract", schema(minimum = 0))]
    pub position: f64,
    /// Standard uncertainty of the height.
    #[cfg_attr(feature = "contract", schema(minimum = 0))]
    pub height: f64,
    /// Kind of the uncertainty where `position` is not 0; default `measured`. Robust estimators,
    /// measurement matrices, streams, shapes near points and `height` 0 treat positions as exact:
    /// there a warning says so, and a kind is refused.
    #[cfg_attr(feature = "contract", serde(rename = "position_kind", skip_serializing_if = "Option::is_none"))]
    pub kind: Option<PositionKind>,
}

/// Kind of position errors. `measured`: the reading is wrong (orthogonal distance regression: the
/// true positions are estimated with the coefficients). `nominal`: the position reached differs
/// from the given one (effective variance: steep places weigh less). In both cases a node has the
/// variance height²/weight + slope² position², up to a factor that follows from `sigma`.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{
///         Degree, Model, NodeUncertainty, PolynomialBasis, PositionKind, Regularization, Terms,
///     },
/// };
///
/// // A ramp whose places are as uncertain as its heights.
/// let x = vec![0.3, 0.8, 2.4, 2.7, 4.1, 5.2, 5.9, 7.3];
/// let y = vec![0.1, 1.2, 1.8, 3.3, 3.9, 4.8, 6.3, 6.9];
/// let nodes = Nodes::curve(x, y, None)?;
/// let (degree, basis) = (Degree::Both(1), PolynomialBasis::Monomial);
/// let model = Model::Polynomial { degree, basis, terms: Terms::Tensor };
/// let spec = FitSpec { regularization: Regularization::None, ..FitSpec::new(model) };
/// let slope = |kind: PositionKind| {
///     let uncertain = NodeUncertainty { position: 0.3, height: 0.3, kind: Some(kind) };
///     let found = fit(&nodes, &FitSpec { node_uncertainty: Some(uncertain), ..spec.clone() })?;
///     Ok::<f64, flankfit_estimation::FitError>(found.coefficients[1].value)
/// };
/// // Places read off wrongly spread the nodes too far, which makes least squares too flat.
/// let plain = fit(&nodes, &spec)?.coefficients[1].value;
/// assert!(slope(PositionKind::Measured)? > plain + 1e-3);
/// // Places that were missed do not, and all have the same weight on a line.
/// assert!((slope(PositionKind::Nominal)? - plain).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum PositionKind {
    /// The place read: what was measured lies elsewhere (orthogonal distance regression).
    #[default]
    Measured,
    /// The place reached: what was aimed at was missed (effective variance).
    Nominal,
}

/// Parts of the response that are included only on request.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Include, Model},
/// };
///
/// let nodes = Nodes::matrix(vec![1.0; 4], 1, vec![1.0, 2.0, 3.0, 6.0], None, None)?;
/// let spec = FitSpec::new(Model::Linear);
/// assert_eq!(fit(&nodes, &spec)?.residuals.values, None);
/// let include = Include { residuals: true, ..Include::default() };
/// let residuals =
///     fit(&nodes, &FitSpec { include, ..spec })?.residuals.values.expect("they were asked for");
/// // The mean is 3.
/// assert!(
///     residuals
///         .iter()
///         .zip([-2.0, -1.0, 0.0, 3.0])
///         .all(|(r, expected)| (r - expected).abs() < 1e-14)
/// );
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Include {
    /// Residuals, node by node.
    pub residuals: bool,
    /// The two n×n collinearity matrices also above the size up to which they are always computed.
    pub collinearity: bool,
    /// The figures that criteria look at, along λ*.
    pub lambda_curve: bool,
    /// Rows of the matrix B.
    pub matrix_b: bool,
    /// Coefficients along k, for ridge.
    pub ridge_trace: bool,
    /// The weights of a robust estimate, node by node.
    pub robust_weights: bool,
    /// The fitted heights, and the heights as filtered.
    pub fitted: bool,
    /// The nodes that filters took for peaks.
    pub peaks: bool,
    /// The covariance matrix of the coefficients.
    pub covariance: bool,
    /// Leverages and deletion figures, node by node.
    pub influence: bool,
    /// The fitted polynomial as a curve or surface.
    pub shape: bool,
    /// Part of the fit that others can use as representative piece.
    pub representative: bool,
    /// The predicted squared error of the regularised estimate, corrected by simulation for λ*
    /// having been chosen by the same nodes.
    pub predicted_mse: bool,
    /// Proved intervals of the least-squares results.
    pub enclosure: bool,
}
