//! Choice of one of several models.

#[cfg(feature = "contract")]
use super::form;
use super::model::Degree;

/// Chooses a model: candidates are looked at by plain least squares, and the best one by
/// `criterion` is fitted in place of the spec's own model.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Candidates, Degree, Model, ModelCriterion, PolynomialBasis, Select, Terms},
/// };
///
/// // A parabola and some noise.
/// let x: Vec<f64> = (0..30).map(|k| 0.1 * f64::from(k)).collect();
/// let y = x.iter().map(|x| 1.0 - x + 0.5 * x * x + 0.02 * (91.0 * x * x).sin()).collect();
/// let model = Model::Polynomial {
///     degree: Degree::Both(1),
///     basis: PolynomialBasis::Monomial,
///     terms: Terms::Tensor,
/// };
/// let select =
///     Select::new(Candidates::Degrees(Degree::Both(6)), ModelCriterion::Bic);
/// let spec = FitSpec { select: Some(select), ..FitSpec::new(model) };
/// let found = fit(&Nodes::curve(x, y, None)?, &spec)?;
/// let selection = found.selection.expect("it was asked for");
/// assert_eq!((selection.candidates.len(), selection.chosen), (7, 2));
/// assert_eq!(found.coefficients.len(), 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "form::Select", into = "form::Select")
)]
pub struct Select {
    /// Candidates of the choice.
    pub candidates: Candidates,
    /// Criterion of the choice.
    pub criterion: ModelCriterion,
    /// True if a product of powers requires those that divide it. Only the columns of a linear
    /// model can do without.
    pub hierarchical: bool,
}

impl Select {
    /// Hierarchical selection.
    pub fn new(candidates: Candidates, criterion: ModelCriterion) -> Self {
        Select { candidates, criterion, hierarchical: true }
    }
}

/// Candidates of the choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Candidates {
    /// Polynomials of every degree from 0 up to these.
    Degrees(Degree),
    /// Subsets of the model's own terms (of a measurement matrix: its columns).
    Terms(TermSearch),
}

/// Search for subsets of terms.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Candidates, Model, ModelCriterion, Select, TermSearch},
/// };
///
/// // Three settings of a machine, of which the second does nothing.
/// let t = |k: i32| f64::from(k) / 10.0 - 1.0;
/// let rows = (0..=20).flat_map(|k| [1.0, t(k), (9.0 * t(k)).cos()]).collect();
/// let heights = (0..=20).map(|k| 3.0 + (9.0 * t(k)).cos() + 0.01 * (37.0 * t(k)).sin()).collect();
/// let nodes = Nodes::matrix(rows, 3, heights, None, None)?;
/// for search in [TermSearch::Backward, TermSearch::ElasticNet { alpha: 0.9 }] {
///     let select = Select::new(Candidates::Terms(search), ModelCriterion::Bic);
///     let found =
///         fit(&nodes, &FitSpec { select: Some(select), ..FitSpec::new(Model::Linear) })?;
///     let terms: Vec<&str> =
///         found.coefficients.iter().map(|coefficient| coefficient.term.as_str()).collect();
///     assert_eq!(terms, ["x0", "x2"]);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TermSearch {
    /// Starts with all terms and drops one after the other: always that which raises the residual
    /// sum of squares least.
    Backward,
    /// The terms that elastic-net estimates keep as their penalty λ falls, `min ½ mean(w r²) + λ(α
    /// Σ|a| + ½(1 − α) Σa²)` in columns of unit variance, the constant free.
    ElasticNet {
        /// α, above 0 and at most 1; 1 is the lasso.
        alpha: f64,
    },
}

/// Criterion that the chosen model minimises; the number of parameters k counts the coefficients
/// and σ². `aicc`: −2 ln L + 2k + 2k(k + 1)/(m − k − 1); `bic`: −2 ln L + k ln m; `press`: Σ w
/// r²/(1 − h)²; `blocked_cv`: Σ w r² of nodes that are left out in blocks (`folds`); `reml`: −2 ln
/// of the marginal likelihood with Zellner's prior of the coefficients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum ModelCriterion {
    /// Akaike's criterion, corrected for few nodes: −2 ln L + 2k + 2k(k + 1)/(m − k − 1).
    Aicc,
    /// Schwarz's criterion: −2 ln L + k ln m.
    Bic,
    /// The sum of squares of leave-one-out residuals.
    Press,
    /// The sum of squares of the residuals of nodes that were left out in blocks
    /// ([`super::Folds`]).
    BlockedCv,
    /// −2 ln of the marginal likelihood with Zellner's prior of the coefficients, flat for the
    /// constant.
    Reml,
}

impl ModelCriterion {
    /// Every criterion there is.
    pub const ALL: [ModelCriterion; 5] = [
        ModelCriterion::Aicc,
        ModelCriterion::Bic,
        ModelCriterion::Press,
        ModelCriterion::BlockedCv,
        ModelCriterion::Reml,
    ];

    /// Stable name.
    pub fn name(self) -> &'static str {
        match self {
            ModelCriterion::Aicc => "aicc",
            ModelCriterion::Bic => "bic",
            ModelCriterion::Press => "press",
            ModelCriterion::BlockedCv => "blocked_cv",
            ModelCriterion::Reml => "reml",
        }
    }
}
