//! Result of a study.

use crate::{result::Warning, spec::Criterion};
use flankfit_numerics::cancel;
use flankfit_numerics::quantiles::quantile;

/// Everything a study found.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyResult {
    /// Eigenvalues of XᵀX, ascending; 0 where numerically zero.
    pub eigenvalues: Vec<f64>,
    /// Least |Pearson correlation| of two columns that vary; `None` with fewer than two of them.
    pub smallest_correlation: Option<f64>,
    /// The largest one, likewise.
    pub largest_correlation: Option<f64>,
    /// |V₁ᵀA|/‖A‖, the share of A along the eigenvector of the smallest eigenvalue; `None` for
    /// A = 0.
    pub along_smallest: Option<f64>,
    /// ‖A‖², by which an estimate of 0 errs.
    pub coefficient_norm_squared: f64,
    /// One entry for each level, in the order given.
    pub levels: Vec<LevelResult>,
    /// Results of least squares and of each regularisation on the same heights.
    pub references: References,
    /// The level of least median error; `None` where no level has one, and without noise.
    pub optimum: Option<Optimum>,
    /// Warnings about this study.
    pub warnings: Vec<Warning>,
}

/// Median and quartiles over the repetitions (interpolated linearly between order statistics).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = Quartiles)
)]
pub struct Summary {
    /// Half of the repetitions lie below.
    pub median: f64,
    /// A quarter of the repetitions lies below.
    pub q1: f64,
    /// Three quarters of the repetitions lie below.
    pub q3: f64,
}

impl Summary {
    /// Quartiles of all values; `None` as soon as one of them does not exist.
    pub fn of(values: impl Iterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.collect();
        if values.is_empty() || values.iter().any(|x| !x.is_finite()) {
            return None;
        }
        values.sort_unstable_by(cancel::comparing(f64::total_cmp));
        let at = |p| quantile(&values, p);
        Some(Summary { median: at(0.5), q1: at(0.25), q3: at(0.75) })
    }
}

/// Results of one estimation method; those that do not exist in every repetition are absent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct MethodResults {
    /// Condition of the inverted matrix: X̃ᵀX̃ of a level, XᵀX of least squares, or the regularised
    /// matrix.
    pub condition: Option<Summary>,
    /// log₁₀ of its determinant.
    pub log10_determinant: Option<Summary>,
    /// ‖A − Â‖².
    pub bias_norm_squared: Option<Summary>,
    /// ‖y − X Â‖², with the X that was not randomised.
    pub rss: Option<Summary>,
}

/// One level of randomisation.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = StudyLevel)
)]
pub struct LevelResult {
    /// k, the level of the perturbation.
    pub level: f64,
    /// Results of the least-squares estimates on the randomised matrices.
    #[cfg_attr(feature = "contract", serde(flatten))]
    pub results: MethodResults,
    /// ‖y − X̃ Â_R‖², the residual sum of squares in the randomised matrix.
    pub fitted_rss: Option<Summary>,
    /// The regularising matrix B of Eq. 40 of the same level, σ_B/σ_X = k; absent where no λ* up to
    /// the largest eigenvalue gives this level, and where the columns are linearly dependent.
    pub matrix_b: Option<LevelOfB>,
}

/// The regularising matrix of one level, on the same heights: first order, as many eigenvalues as
/// are above the usual condition limit.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = StudyLevelOfB)
)]
pub struct LevelOfB {
    /// λ* at which the root mean square over the columns that vary of ‖B_j‖/(√m σ_j) is the level.
    pub lambda_star: f64,
    /// Results of its estimates.
    #[cfg_attr(feature = "contract", serde(flatten))]
    pub results: MethodResults,
}

impl LevelResult {
    pub(super) fn complete(&self) -> bool {
        let f = &self.results;
        [f.condition, f.log10_determinant, f.bias_norm_squared, f.rss, self.fitted_rss].iter().all(Option::is_some)
    }
}

/// One criterion for λ* or k, applied in every repetition with the study's σ.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = StudyChoice)
)]
pub struct ReferenceChoice {
    /// The criterion that chose λ* or k.
    pub criterion: Criterion,
    /// Results of the estimate.
    #[cfg_attr(feature = "contract", serde(flatten))]
    pub chosen: Regularized,
}

/// Results of a regularised estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = RegularizedResults)
)]
pub struct Regularized {
    /// λ* of the spectral schemes, k of ridge.
    pub lambda_star: Option<Summary>,
    /// σ_B/σ_X of the spectral schemes: size of B relative to the columns it is added to, on the
    /// scale of the levels.
    pub noise_to_signal: Option<Summary>,
    /// Results of its estimates.
    #[cfg_attr(feature = "contract", serde(flatten))]
    pub results: MethodResults,
}

/// A way of regularising, with every criterion that has an answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// L; `None` for ridge.
    pub count: Option<usize>,
    /// One entry for each criterion that has an answer.
    pub choices: Vec<ReferenceChoice>,
}

/// Every reference.
#[derive(Clone, Debug, PartialEq)]
pub struct References {
    /// Least squares on the matrix as it is.
    pub least_squares: MethodResults,
    /// `None` where λ₁ is numerically zero, by which Eq. 39 divides.
    pub spectral_first_order: Option<Reference>,
    /// The scheme of exact eigenvalues; `None` where λ₁ is numerically zero.
    pub spectral_exact: Option<Reference>,
    /// Ridge regression.
    pub ridge: Reference,
}

/// Medians of one level relative to least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = StudyRatios)
)]
pub struct LevelRatios {
    /// The level itself.
    pub level: f64,
    /// Median ‖A − Â‖² of least squares over that of this level; its root is the ratio of norms.
    pub error_ratio: f64,
    /// cond(XᵀX) over the median cond(X̃ᵀX̃) of this level.
    pub condition_ratio: Option<f64>,
    /// Median ‖y − X Â_R‖² of this level over that of least squares.
    pub rss_ratio: Option<f64>,
}

/// The level of least median error, and those that do nearly as well.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = StudyOptimum)
)]
pub struct Optimum {
    /// The best level.
    #[cfg_attr(feature = "contract", serde(flatten))]
    pub best: LevelRatios,
    /// Lowest and highest level about the best one where ‖A − Â_R‖ is at most 5 % above the least.
    #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
    pub plateau: [f64; 2],
    /// The level of least condition on the plateau: the accuracy is the same, the matrix is
    /// conditioned best.
    pub least_condition: LevelRatios,
}
