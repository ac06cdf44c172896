//! Influence of each node on the fit.

/// How much each counted node has a say in a fit, in the order of the residuals. What the other
/// nodes leave undetermined (a node of leverage 1) is `None`.
///
/// A regularised fit is looked at with its penalty held: the penalty is that of all nodes, and λ*
/// is not chosen anew without a node.
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
pub struct Influence {
    /// hᵢ, the diagonal of the matrix that turns heights into fitted ones.
    pub leverage: Vec<f64>,
    /// √wᵢ rᵢ / (σ̂ √(1 − hᵢ)); `None` without an estimate of the noise.
    pub internally_studentized: Option<Vec<Option<f64>>>,
    /// The same with the σ̂ of the other nodes; `None` without degrees of freedom for it.
    pub externally_studentized: Option<Vec<Option<f64>>>,
    /// Σ w (change of the fitted heights)² without the node, over σ̂² Σh; `None` without an
    /// estimate of the noise.
    pub cooks_distance: Option<Vec<Option<f64>>>,
    /// Change of the node's own fitted height without it, over the standard error of that height
    /// with the σ̂ of the other nodes; `None` without degrees of freedom for it.
    pub dffits: Option<Vec<Option<f64>>>,
    /// rᵢ / (1 − hᵢ): the height less what the fit to the other nodes says there.
    pub press_residual: Vec<Option<f64>>,
    /// Σ w r²/(1 − h)²; `None` where a node is undetermined by the others.
    pub press: Option<f64>,
    /// Which posted node each entry belongs to; present when some node was left out.
    pub node_indices: Option<Vec<usize>>,
}

impl Influence {
    /// Whether every number is one.
    pub(crate) fn is_finite(&self) -> bool {
        let list = |list: &[Option<f64>]| list.iter().flatten().all(|x| x.is_finite());
        let lists = [&self.internally_studentized, &self.externally_studentized, &self.cooks_distance, &self.dffits];
        self.leverage.iter().all(|h| h.is_finite())
            && lists.into_iter().flatten().all(|values| list(values))
            && list(&self.press_residual)
            && self.press.is_none_or(f64::is_finite)
    }
}
