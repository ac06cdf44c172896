//! The answer to a randomisation study, as it is written.

use std::ops::Range;

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{
    reader::{CheckedStudy, read},
    request::StudyScaling,
};
use crate::api::{faults::moved, problem::Problem, warning::WarningBody};
use flankfit_engine::estimation::{
    FitError,
    randomization::{
        self, Figures, LevelRatios, LevelResult, Outcome, Reference, ReferenceChoice, StudyResult, Summary,
    },
    spec::{ChosenBy, Criterion},
};

/// Comparison of randomising the measurement matrix with regularising.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RandomizationResult {
    /// Rows of the measurement matrix.
    pub count: usize,
    /// Names of the columns, in order.
    pub terms: Vec<String>,
    /// A, from the request or estimated from the nodes' heights.
    pub coefficients: Vec<f64>,
    /// Source of A.
    pub coefficients_source: LimitSource,
    /// σ of a height.
    pub noise_sigma: f64,
    pub noise_sigma_source: LimitSource,
    pub scaling: StudyScaling,
    /// Random matrices for each level.
    pub repetitions: usize,
    /// The seed that was used: the same one gives the same answer.
    pub seed: u64,
    /// Eigenvalues of XᵀX, ascending.
    pub eigenvalues: Vec<f64>,
    /// Least |Pearson correlation| of two columns that vary.
    pub smallest_correlation: Option<f64>,
    /// Largest |Pearson correlation| of two columns that vary.
    pub largest_correlation: Option<f64>,
    /// |V₁ᵀA|/‖A‖: how much of A lies along the eigenvector of the smallest eigenvalue; absent for
    /// A = 0.
    pub along_smallest: Option<f64>,
    /// ‖A‖² in the columns of the study, by which an estimate of 0 errs.
    pub coefficient_norm_squared: f64,
    /// Note on reading the figures.
    pub remark: String,
    /// Figures of each level, in ascending order.
    pub levels: Vec<StudyLevel>,
    pub references: StudyReferences,
    /// The level of least median ‖A − Â_R‖²; absent without noise, where least squares is exact.
    pub optimum: Option<StudyOptimum>,
    /// What to know about the answer; empty where there is nothing to say.
    pub warnings: Vec<WarningBody>,
    /// Version of the engine.
    #[schema(example = "flankfit 0.1.0")]
    pub engine: String,
}

/// Median and quartiles over the repetitions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Quartiles {
    /// Half of the repetitions lie below.
    pub median: f64,
    /// A quarter of the repetitions lies below.
    pub q1: f64,
    /// Three quarters of the repetitions lie below.
    pub q3: f64,
}

/// Figures of one estimation method; those that do not exist in every repetition are absent.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StudyFigures {
    /// Condition of the inverted matrix: X̃ᵀX̃ of a level, XᵀX of least squares, or the regularised
    /// matrix.
    pub condition: Option<Quartiles>,
    /// log₁₀ of its determinant.
    pub log10_determinant: Option<Quartiles>,
    /// ‖A − Â‖².
    pub bias_norm_squared: Option<Quartiles>,
    /// ‖y − X Â‖², with the X that was not randomised.
    pub rss: Option<Quartiles>,
}

/// One level of randomisation.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StudyLevel {
    /// k, the level: how strongly the matrices are perturbed.
    pub level: f64,
    #[serde(flatten)]
    pub figures: StudyFigures,
    /// ‖y − X̃ Â_R‖², the residual sum of squares in the randomised matrix.
    pub fitted_rss: Option<Quartiles>,
    /// The regularising matrix B of Eq. 40 of the same level, σ_B/σ_X = k; absent where no λ* up to
    /// the largest eigenvalue gives this level, and where the columns are linearly dependent.
    pub matrix_b: Option<StudyLevelOfB>,
}

/// The regularising matrix of one level, on the same heights: first order, as many eigenvalues as
/// lie beyond the usual condition limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StudyLevelOfB {
    /// λ* at which the root mean square over the columns that vary of ‖B_j‖/(√m σ_j) is the level.
    pub lambda_star: f64,
    #[serde(flatten)]
    pub figures: StudyFigures,
}

/// The same heights, estimated with X as it is.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StudyReferences {
    pub least_squares: StudyFigures,
    /// Absent where the columns are linearly dependent.
    pub spectral_first_order: Option<RegularizedReference>,
    /// Absent where the columns are linearly dependent.
    pub spectral_exact: Option<RegularizedReference>,
    pub ridge: RegularizedReference,
}

/// A regularised estimate: figures of the default criterion (`min_mse`), and of every criterion in
/// `choices`.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RegularizedReference {
    /// L of the spectral schemes.
    pub count: Option<usize>,
    #[serde(flatten)]
    pub chosen: RegularizedFigures,
    /// One entry for each criterion.
    pub choices: Vec<StudyChoice>,
}

/// What a regularised estimate comes to.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RegularizedFigures {
    /// λ* of the spectral schemes, k of ridge.
    pub lambda_star: Option<Quartiles>,
    /// σ_B/σ_X of the spectral schemes: size of B relative to the columns it is added to, on the
    /// scale of the levels.
    pub noise_to_signal: Option<Quartiles>,
    #[serde(flatten)]
    pub figures: StudyFigures,
}

/// One criterion for λ* or k, applied in every repetition with the study's σ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StudyChoice {
    pub criterion: ChosenBy,
    #[serde(flatten)]
    pub chosen: RegularizedFigures,
}

/// The level of least median error, and those that do nearly as well.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StudyOptimum {
    #[serde(flatten)]
    pub best: StudyRatios,
    /// Lowest and highest level about the best one where ‖A − Â_R‖ is at most 5 % above the least.
    #[schema(min_items = 2, max_items = 2)]
    pub plateau: [f64; 2],
    /// The level of least condition on the plateau: the accuracy is the same, the matrix is
    /// conditioned best.
    pub least_condition: StudyRatios,
}

/// Medians of one level relative to least squares.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StudyRatios {
    /// The level itself.
    pub level: f64,
    /// Median ‖A − Â‖² of least squares over that of this level; its root is the ratio of norms.
    pub error_ratio: f64,
    /// cond(XᵀX) over the median cond(X̃ᵀX̃) of this level.
    pub condition_ratio: Option<f64>,
    /// Median ‖y − X Â_R‖² of this level over that of least squares.
    pub rss_ratio: Option<f64>,
}

fn quartiles(summary: Option<Summary>) -> Option<Quartiles> {
    summary.map(|Summary { median, q1, q3 }| Quartiles { median, q1, q3 })
}

/// Runs a request to its answer. Processor work.
pub fn answer(text: &[u8]) -> Result<RandomizationResult, Problem> {
    let checked = read(text)?;
    let result = randomization::run(&checked.study).map_err(refused)?;
    Ok(RandomizationResult::new(result, checked))
}

/// Some repetitions of a study, in order. Processor work.
pub fn repetitions(checked: &CheckedStudy, which: Range<usize>) -> Result<Vec<Outcome>, Problem> {
    randomization::repetitions(&checked.study, which).map_err(refused)
}

/// The same answer from all repetitions in order.
pub fn of_repetitions(checked: CheckedStudy, outcomes: &[Outcome]) -> Result<RandomizationResult, Problem> {
    let result = randomization::of_repetitions(&checked.study, outcomes).map_err(refused)?;
    Ok(RandomizationResult::new(result, checked))
}

/// The study's matrix goes through the checks of nodes of type matrix, whose lists stand in the
/// request itself.
fn place(path: &str) -> String {
    match path {
        "nodes" => "/x".to_owned(),
        _ => moved(path, &[("nodes", "")]),
    }
}

fn refused(error: FitError) -> Problem {
    Problem::of_fit(error, place)
}

/// Source of the limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LimitSource {
    Estimate,
    Request,
}

impl RandomizationResult {
    pub(in crate::api) fn new(result: StudyResult, study: CheckedStudy) -> Self {
        let source = |given: bool| if given { LimitSource::Request } else { LimitSource::Estimate };
        RandomizationResult {
            count: study.rows,
            terms: study.terms,
            coefficients: study.coefficients,
            coefficients_source: source(study.coefficients_given),
            noise_sigma: study.noise_sigma,
            noise_sigma_source: source(study.noise_sigma_given),
            scaling: study.scaling,
            repetitions: study.repetitions,
            seed: study.seed,
            eigenvalues: result.eigenvalues,
            smallest_correlation: result.smallest_correlation,
            largest_correlation: result.largest_correlation,
            along_smallest: result.along_smallest,
            coefficient_norm_squared: result.coefficient_norm_squared,
            remark: remark(result.along_smallest, result.coefficient_norm_squared),
            levels: result.levels.into_iter().map(level).collect(),
            references: StudyReferences {
                least_squares: figures(&result.references.least_squares),
                spectral_first_order: result.references.spectral_first_order.map(regularized),
                spectral_exact: result.references.spectral_exact.map(regularized),
                ridge: regularized(result.references.ridge),
            },
            optimum: result.optimum.map(|o| StudyOptimum {
                best: ratios(o.best),
                plateau: o.plateau,
                least_condition: ratios(o.least_condition),
            }),
            warnings: result.warnings.iter().map(WarningBody::from).collect(),
            engine: crate::api::ENGINE.to_owned(),
        }
    }

    /// The JSON text.
    pub fn to_json(&self) -> Result<Vec<u8>, serde_json::Error> {
        serde_json::to_vec(self)
    }
}

/// How the outcome hangs on where A lies.
fn remark(along: Option<f64>, norm_squared: f64) -> String {
    const SHRINKS: &str =
        "randomising, like every regularisation, shrinks what lies along the eigenvector V₁ of the smallest eigenvalue";
    match along {
        Some(share) => format!(
            "{SHRINKS}; here |V₁ᵀA|/‖A‖ = {share:.3e}, and an A that lies otherwise gives other figures with the same \
             matrix; an estimate of 0 errs by ‖A‖² = {norm_squared:.3e}"
        ),
        None => format!("{SHRINKS}; here A is 0, which no shrinking can harm"),
    }
}

fn figures(f: &Figures) -> StudyFigures {
    StudyFigures {
        condition: quartiles(f.condition),
        log10_determinant: quartiles(f.log10_determinant),
        bias_norm_squared: quartiles(f.bias_norm_squared),
        rss: quartiles(f.rss),
    }
}

fn level(l: LevelResult) -> StudyLevel {
    StudyLevel {
        level: l.level,
        figures: figures(&l.figures),
        fitted_rss: quartiles(l.fitted_rss),
        matrix_b: l.matrix_b.map(|b| StudyLevelOfB { lambda_star: b.lambda_star, figures: figures(&b.figures) }),
    }
}

fn ratios(r: LevelRatios) -> StudyRatios {
    StudyRatios {
        level: r.level,
        error_ratio: r.error_ratio,
        condition_ratio: r.condition_ratio,
        rss_ratio: r.rss_ratio,
    }
}

fn chosen(c: &ReferenceChoice) -> RegularizedFigures {
    RegularizedFigures {
        lambda_star: quartiles(c.lambda_star),
        noise_to_signal: quartiles(c.noise_to_signal),
        figures: figures(&c.figures),
    }
}

fn regularized(reference: Reference) -> RegularizedReference {
    let default = reference.choices.iter().find(|c| c.criterion == Criterion::MinMse);
    let choice = |c: &ReferenceChoice| StudyChoice { criterion: ChosenBy::Criterion(c.criterion), chosen: chosen(c) };
    RegularizedReference {
        count: reference.count,
        chosen: default.map(chosen).unwrap_or_default(),
        choices: reference.choices.iter().map(choice).collect(),
    }
}
