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
        self, LevelResult, MethodResults, Optimum, Outcome, Reference, ReferenceChoice, Regularized, StudyResult,
    },
    spec::Criterion,
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
    /// The seed that was used: the same seed gives the same result.
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
    /// ‖A‖² in the columns of the study, the error of an estimate of 0.
    pub coefficient_norm_squared: f64,
    /// Note on reading the results.
    pub remark: String,
    /// Results of each level, in ascending order.
    pub levels: Vec<LevelResult>,
    pub references: StudyReferences,
    /// The level of least median ‖A − Â_R‖²; absent without noise, where least squares is exact.
    pub optimum: Option<Optimum>,
    /// Warnings about the result.
    pub warnings: Vec<WarningBody>,
    /// Version of the engine.
    #[schema(example = "flankfit 0.1.0")]
    pub engine: String,
}

/// The same heights, estimated with X as it is.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StudyReferences {
    pub least_squares: MethodResults,
    /// Absent where the columns are linearly dependent.
    pub spectral_first_order: Option<RegularizedReference>,
    /// Absent where the columns are linearly dependent.
    pub spectral_exact: Option<RegularizedReference>,
    pub ridge: RegularizedReference,
}

/// A regularised estimate: results of the default criterion (`min_mse`), and of every criterion in
/// `choices`.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RegularizedReference {
    /// L of the spectral schemes.
    pub count: Option<usize>,
    #[serde(flatten)]
    pub chosen: Regularized,
    /// One entry for each criterion.
    pub choices: Vec<ReferenceChoice>,
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
            levels: result.levels,
            references: StudyReferences {
                least_squares: result.references.least_squares,
                spectral_first_order: result.references.spectral_first_order.map(regularized),
                spectral_exact: result.references.spectral_exact.map(regularized),
                ridge: regularized(result.references.ridge),
            },
            optimum: result.optimum,
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
    const SHRINKS: &str = "randomisation, like every regularisation, shrinks the part along the eigenvector V₁ of the \
        smallest eigenvalue";
    match along {
        Some(share) => format!(
            "{SHRINKS}; here |V₁ᵀA|/‖A‖ = {share:.3e}, and another A gives other results with the same matrix; an \
             estimate of 0 has the error ‖A‖² = {norm_squared:.3e}"
        ),
        None => format!("{SHRINKS}; here A is 0, so shrinking does no harm"),
    }
}

fn regularized(Reference { count, choices }: Reference) -> RegularizedReference {
    let default = choices.iter().find(|choice| choice.criterion == Criterion::MinMse);
    RegularizedReference { count, chosen: default.map(|choice| choice.chosen).unwrap_or_default(), choices }
}
