//! Randomisation study (6.3, Figs. 4 and 5): effect of random changes of the measurement matrix on
//! an estimate, compared with that of regularisation.
//!
//! A known `A` gives heights `y = X A + e`, e normal with deviation σ. In every repetition X is
//! randomised in space, `X̃ = X + k · (deviation of the column) · (standard normal)` for each level
//! `k = σ_noise/σ_signal`, and `Â_R` is the least-squares estimate of `y` on `X̃`. A constant
//! column has no deviation and stays as it is. Reported are medians and quartiles of cond(X̃ᵀX̃),
//! log₁₀ det(X̃ᵀX̃), ‖A − Â_R‖² and the residual sums. From the same heights follow least squares,
//! both spectral schemes and ridge with every criterion that has a result. The regularising matrix
//! B, read as noise on the columns (`matrix_b`), is reported for each level.
//!
//! The outcome depends on where A lies relative to the eigenvector V₁ of the smallest eigenvalue,
//! because every one of these methods shrinks what lies along it: [`StudyResult::along_smallest`]
//! says where. Norms are of coefficients as given, or with `unit_length` of those that belong to
//! columns of length 1.
//!
//! *Without cancellation.* `D = A − Â_R` solves `X̃ D ≈ (X̃ − X) A − e`, so it is computed itself,
//! never as a difference of two estimates; arithmetic is of twice the precision where X̃ is so near
//! to dependence that doubles would not do. *Reproducible.* Repetition r draws from stream r of the
//! seed (`normal`): first e, then the changes of X row by row, the same for every level.
//! Repetitions are computed in parallel and gathered in order. [`repetitions`] computes some of
//! them and [`of_repetitions`] gathers all, for studies that are computed on several machines.

mod matrix_b;
mod measured;
pub mod normal;
mod outcome;
mod plateau;
mod references;
mod repetition;
mod result;
mod setup;

pub use measured::Measured;
pub use outcome::{LevelOutcome, Outcome};
pub use plateau::PLATEAU;
pub use result::{
    LevelOfB, LevelRatios, LevelResult, MethodResults, Optimum, Reference, ReferenceChoice, References, Regularized,
    StudyResult, Summary,
};
pub use setup::{ColumnScaling, Setup, Study};

use std::ops::Range;

use rayon::prelude::*;

use super::{error::FitError, result::Warning};
use flankfit_numerics::cancel;
use references::Base;

/// Runs a study. Processor work, bounded by `setup::MOST_WORK`.
///
/// ```
/// use flankfit_estimation::randomization::{ColumnScaling, Setup, Study, run};
///
/// // Two columns that are nearly one. Noise on them lowers the condition, as regularisation does.
/// let x = (0..12)
///     .map(|k| f64::from(k) / 11.0)
///     .map(|t| vec![1.0 + t, 1.0 + t + 0.01 * t * t])
///     .collect();
/// let setup = Setup {
///     x,
///     coefficients: vec![1.0, 1.0],
///     noise_sigma: 0.01,
///     levels: vec![0.0, 0.03, 0.1],
///     repetitions: 50,
///     seed: 7,
///     scaling: ColumnScaling::None,
/// };
/// let found = run(&Study::new(setup)?)?;
/// let conditions: Vec<f64> = found
///     .levels
///     .iter()
///     .map(|level| level.results.condition.expect("full rank").median)
///     .collect();
/// let condition = found.eigenvalues[1] / found.eigenvalues[0];
/// assert!((conditions[0] / condition - 1.0).abs() < 1e-6);
/// assert!(conditions[0] > 10.0 * conditions[1] && conditions[1] > conditions[2]);
/// // An estimate on randomised columns may err less than least squares does.
/// let best = found.optimum.expect("there is noise").best;
/// assert!(best.level > 0.0 && best.error_ratio > 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn run(study: &Study) -> Result<StudyResult, FitError> {
    let base = Base::new(study)?;
    let outcomes = draw(study, &base, 0..study.repetitions)?;
    Ok(gathered(study, &base, &outcomes))
}

/// Some repetitions of a study, in order: what it is gathered from.
pub fn repetitions(study: &Study, which: Range<usize>) -> Result<Vec<Outcome>, FitError> {
    draw(study, &Base::new(study)?, which)
}

/// Result of [`run`], to the bit, from all repetitions in order, wherever they were computed. Each
/// must be of this study ([`Study::takes`]).
///
/// ```
/// use flankfit_estimation::randomization::{
///     ColumnScaling, Setup, Study, of_repetitions, repetitions, run,
/// };
///
/// let setup = Setup {
///     x: (0..9).map(|k| vec![1.0, f64::from(k)]).collect(),
///     coefficients: vec![1.0, 0.5],
///     noise_sigma: 0.1,
///     levels: vec![0.01, 0.1],
///     repetitions: 30,
///     seed: 3,
///     scaling: ColumnScaling::None,
/// };
/// let study = Study::new(setup)?;
/// let mut all = repetitions(&study, 0..10)?;
/// all.extend(repetitions(&study, 10..30)?);
/// assert_eq!(of_repetitions(&study, &all)?, run(&study)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn of_repetitions(study: &Study, outcomes: &[Outcome]) -> Result<StudyResult, FitError> {
    Ok(gathered(study, &Base::new(study)?, outcomes))
}

fn draw(study: &Study, base: &Base, which: Range<usize>) -> Result<Vec<Outcome>, FitError> {
    let (handle, all) = (cancel::current(), cancel::parts(which.len()));
    let repetition = |stream| {
        cancel::checkpoint();
        all.run(1, || repetition::run(study, base, stream))
    };
    (which.start as u64..which.end as u64)
        .into_par_iter()
        .map(|stream| cancel::carry(handle.as_ref(), || repetition(stream)))
        .collect()
}

fn gathered(study: &Study, base: &Base, outcomes: &[Outcome]) -> StudyResult {
    let mut warnings = Vec::new();
    let levels: Vec<LevelResult> = study
        .levels
        .iter()
        .enumerate()
        .map(|(at, &level)| {
            let of = |f: &dyn Fn(&outcome::LevelOutcome) -> f64| Summary::of(outcomes.iter().map(|o| f(&o.levels[at])));
            LevelResult {
                level,
                results: MethodResults {
                    condition: of(&|d| d.condition),
                    log10_determinant: of(&|d| d.log10_determinant),
                    bias_norm_squared: of(&|d| d.error),
                    rss: of(&|d| d.rss),
                },
                fitted_rss: of(&|d| d.fitted_rss),
                matrix_b: base.of_level(outcomes, level),
            }
        })
        .collect();
    let lost: Vec<f64> = levels.iter().filter(|l| !l.complete()).map(|l| l.level).collect();
    if !lost.is_empty() {
        warnings.push(Warning::DependentLevels { levels: lost });
    }
    let references = base.references(outcomes, &mut warnings);
    let optimum = if study.noise_sigma > 0.0 {
        plateau::optimum(&levels, &references.least_squares)
    } else {
        warnings.push(Warning::NoNoise);
        None
    };
    StudyResult {
        eigenvalues: base.lambda().to_vec(),
        smallest_correlation: base.correlation.map(|c| c[0]),
        largest_correlation: base.correlation.map(|c| c[1]),
        along_smallest: base.along_smallest(),
        coefficient_norm_squared: base.coefficient_norm_squared(),
        levels,
        references,
        optimum,
        warnings,
    }
}

#[cfg(test)]
mod tests;
