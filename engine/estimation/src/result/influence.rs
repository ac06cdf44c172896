//! Influence of each node on the fit.

/// Influence of each counted node on the fit, in the order of `residuals.values`; null where a
/// figure does not exist: without a node of leverage 1 the other nodes do not determine the fit
/// (warning `full_leverage`), and figures that are divided by σ̂ need noise (warning
/// `no_noise_without`). For a regularised fit the penalty of all nodes is held fixed: λ* is not
/// chosen again without a node. Residuals include √weight where nodes have weights.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Include, Model, Regularization},
/// };
///
/// // The mean of four heights: each has a quarter of it.
/// let nodes = Nodes::matrix(vec![1.0; 4], 1, vec![1.0, 2.0, 3.0, 10.0], None, None)?;
/// let spec = FitSpec {
///     regularization: Regularization::None,
///     include: Include { influence: true, ..Include::default() },
///     ..FitSpec::new(Model::Linear)
/// };
/// let found = fit(&nodes, &spec)?.influence.expect("it was asked for");
/// assert!(found.leverage.iter().all(|h| (h - 0.25).abs() < 1e-15));
/// // The mean of the other three is 2, so the last one is 8 off.
/// assert!(found.press_residual[3].is_some_and(|r| (r - 8.0).abs() < 1e-14));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Influence {
    /// hᵢ, from 0 to 1: derivative of the fitted height with respect to the node's own height.
    /// The sum over the nodes is the effective number of coefficients.
    pub leverage: Vec<f64>,
    /// √wᵢ rᵢ / (σ̂ √(1 − hᵢ)), σ̂ being `residuals.sigma`; null where σ̂ is 0. Absent without
    /// degrees of freedom.
    pub internally_studentized: Option<Vec<Option<f64>>>,
    /// The same with the σ̂ of least squares without the node: for normal errors and no
    /// regularisation, Student's t with m − n − 1 degrees of freedom; null where the other
    /// nodes are fitted exactly. Absent without these degrees of freedom.
    pub externally_studentized: Option<Vec<Option<f64>>>,
    /// Cook's distance: Σ w (change of the fitted heights without the node)² / (σ̂² Σh); null
    /// where σ̂ is 0.
    pub cooks_distance: Option<Vec<Option<f64>>>,
    /// Change of the node's own fitted height without it, in standard errors of that height
    /// with the σ̂ of the other nodes; null where those are fitted exactly.
    pub dffits: Option<Vec<Option<f64>>>,
    /// rᵢ/(1 − hᵢ), in the unit of the heights: the height minus the prediction by a fit to the
    /// other nodes.
    pub press_residual: Vec<Option<f64>>,
    /// Σ w r²/(1 − h)²: the sum of squares of leave-one-out cross-validation. Absent where a
    /// node has leverage 1.
    pub press: Option<f64>,
    /// The posted node (from 0, grids row by row) of each entry; present if some node was omitted.
    pub node_indices: Option<Vec<usize>>,
}

impl Influence {
    /// True if every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        let list = |list: &[Option<f64>]| list.iter().flatten().all(|x| x.is_finite());
        let lists = [&self.internally_studentized, &self.externally_studentized, &self.cooks_distance, &self.dffits];
        self.leverage.iter().all(|h| h.is_finite())
            && lists.into_iter().flatten().all(|values| list(values))
            && list(&self.press_residual)
            && self.press.is_none_or(f64::is_finite)
    }
}
