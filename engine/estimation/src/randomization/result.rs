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
pub struct Summary {
    /// Median.
    pub median: f64,
    /// Lower quartile.
    pub q1: f64,
    /// Upper quartile.
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

/// Results of one way of estimating.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figures {
    /// Condition of the (randomised, regularised) Fisher information matrix.
    pub condition: Option<Summary>,
    /// log₁₀ of the determinant of the same matrix.
    pub log10_determinant: Option<Summary>,
    /// ‖A − Â‖².
    pub bias_norm_squared: Option<Summary>,
    /// ‖y − X Â‖² with the X that was not randomised.
    pub rss: Option<Summary>,
}

/// One level of randomisation.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelResult {
    /// k.
    pub level: f64,
    /// Results of the least-squares estimates on the randomised matrices.
    pub figures: Figures,
    /// ‖y − X̃ Â_R‖², what the randomised fit itself sees.
    pub fitted_rss: Option<Summary>,
    /// The regularising matrix B of the same level; `None` where no λ* up to λₙ has it.
    pub matrix_b: Option<LevelOfB>,
}

/// Results of the regularising matrix of one level (first order, as many eigenvalues as lie above
/// the usual condition limit).
#[derive(Clone, Debug, PartialEq)]
pub struct LevelOfB {
    /// λ* at which σ_B/σ_X is the level.
    pub lambda_star: f64,
    /// Results of its estimates.
    pub figures: Figures,
}

impl LevelResult {
    pub(super) fn complete(&self) -> bool {
        let f = &self.figures;
        [f.condition, f.log10_determinant, f.bias_norm_squared, f.rss, self.fitted_rss].iter().all(Option::is_some)
    }
}

/// A regularised estimate with one criterion.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceChoice {
    /// The criterion that chose λ* or k.
    pub criterion: Criterion,
    /// λ* of the spectral schemes, k of ridge; `None` where nothing was regularised.
    pub lambda_star: Option<Summary>,
    /// σ_B/σ_X of the spectral schemes: the size of B relative to the columns that it is added to.
    pub noise_to_signal: Option<Summary>,
    /// Results of its estimates.
    pub figures: Figures,
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
    pub least_squares: Figures,
    /// `None` where λ₁ is numerically zero, by which Eq. 39 divides.
    pub spectral_first_order: Option<Reference>,
    /// The scheme of exact eigenvalues; `None` where λ₁ is numerically zero.
    pub spectral_exact: Option<Reference>,
    /// Ridge regression.
    pub ridge: Reference,
}

/// Medians of least squares over those of one level, and for the residuals the other way round.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelRatios {
    /// k.
    pub level: f64,
    /// ‖A − Â‖² of least squares over that of the level.
    pub error_ratio: f64,
    /// cond(XᵀX) over cond(X̃ᵀX̃).
    pub condition_ratio: Option<f64>,
    /// ‖y − XÂ_R‖² over that of least squares.
    pub rss_ratio: Option<f64>,
}

/// The level of least median ‖A − Â_R‖², and those that do nearly as well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optimum {
    /// The best level.
    pub best: LevelRatios,
    /// Lowest and highest level about it without one between whose error is greater than
    /// [`super::PLATEAU`] times the least.
    pub plateau: [f64; 2],
    /// The level of least condition among them.
    pub least_condition: LevelRatios,
}
