//! Truncated singular value decomposition: the directions of the k largest singular values are kept
//! as they are, the others are left out, `f = 1` or 0.
//!
//! It needs no λ₁ > 0, so it exists for dependent columns too. Its matrix, `U Σ_k Vᵀ`, has
//! eigenvalue 0 along what was left out; its condition is that of the kept directions, and it has
//! no determinant.

use super::{
    bias, chosen_rank,
    context::{Applied, Context},
    linear_map::LinearMap,
    report::{condition, report},
};
use crate::{
    error::FitError,
    estimate::{Estimate, residuals},
    result::{Choice, RegularizationKind, RegularizationReport, RegularizedSpectrum, Warning},
    selection::{Filtered, Rule, Unavailable, selector::no_minimiser},
    spec::{ChosenBy, Criterion},
};
use flankfit_numerics::check::Faults;

/// Refuses to keep none, or more than `there` are.
pub(super) fn check_rank(rank: usize, there: usize, of: &str) -> Result<(), Faults> {
    if (1..=there).contains(&rank) {
        return Ok(());
    }
    let path = "regularization.rank";
    Err(match there {
        0 => Faults::one(path, "every column is 0 at these nodes: there is no direction to keep"),
        _ => {
            let message = format_args!("{rank} of {there} {of} in the scaled columns: at least 1, at most all");
            Faults::one(path, message)
        }
    })
}

/// Refuses a criterion that chooses no rank.
pub(super) fn check_criterion(criterion: Criterion) -> Result<(), Faults> {
    if Criterion::OF_RANK.contains(&criterion) {
        return Ok(());
    }
    Err(Faults::one(
        "regularization.parameter.criterion",
        format_args!("{} cannot choose a rank: use gcv, reml or discrepancy", criterion.name()),
    ))
}

/// Keeps as many as `criterion` chooses; all of them where it has no answer.
pub(super) fn apply_by(
    context: &Context,
    criterion: Criterion,
    warnings: &mut Vec<Warning>,
) -> Result<Applied, FitError> {
    let Context { spectrum, .. } = *context;
    let problem = context.spectral_problem(&spectrum.lambda, &spectrum.a);
    let rank = match chosen_rank::choose(criterion, &problem, &spectrum.a) {
        Ok(rank) => rank,
        Err(Unavailable::NoSigma) => {
            warnings.push(Warning::SigmaMissing { criterion: criterion.name() });
            spectrum.rank
        }
        Err(Unavailable::NoMinimiser) => return Err(no_minimiser(criterion).into()),
    };
    let applied = apply(context, rank, warnings)?;
    let regularization =
        RegularizationReport { criterion: Some(ChosenBy::Criterion(criterion)), ..applied.regularization };
    Ok(Applied { regularization, ..applied })
}

/// Keeps the `rank` largest singular values.
pub(super) fn apply(context: &Context, rank: usize, warnings: &mut Vec<Warning>) -> Result<Applied, FitError> {
    let Context { spec, spectrum, columns, least_squares, linear, .. } = *context;
    let n = spectrum.lambda.len();
    check_rank(rank, spectrum.rank, "singular values above rounding")?;
    let dropped = n - rank;
    let filtered: Vec<Filtered> = (0..n)
        .map(|i| match i < dropped {
            true => Filtered { factor: 0.0, removed: 1.0, eigenvalue: 0.0 },
            false => Filtered { factor: 1.0, removed: 0.0, eigenvalue: spectrum.lambda[i] },
        })
        .collect();
    let (lambda, a) = (&spectrum.lambda, &spectrum.a);
    let problem = context.spectral_problem(lambda, a);
    let least = Choice {
        criterion: ChosenBy::LeastSquares,
        lambda_star: None,
        condition: problem.condition(Rule::None, 0.0),
        bias_norm: 0.0,
        predicted_mse: problem.variance.map(|_| problem.sums(Rule::None, 0.0).mse[0]),
        rms: (least_squares.rss / context.weight).sqrt(),
    };
    let rss = least_squares.rss + (0..dropped).map(|i| lambda[i] * a[i] * a[i]).sum::<f64>();
    let standing = Choice {
        bias_norm: a[..dropped].iter().map(|a| a * a).sum::<f64>().sqrt(),
        predicted_mse: context.variance.map(|variance| {
            (0..n)
                .filter(|&i| lambda[i] > 0.0)
                .map(|i| match i < dropped {
                    true => (a[i] * a[i] - variance / lambda[i]).max(0.0),
                    false => variance / lambda[i],
                })
                .sum()
        }),
        rms: (rss / context.weight).sqrt(),
        ..least.clone()
    };
    let choices = vec![least];
    context.judge(&choices, &standing, warnings);
    context.warn_of_missing("truncated_svd", false, warnings);
    let estimate = Estimate::new(columns, spectrum, &filtered, least_squares);
    let residuals = residuals(linear, spectrum, &filtered, &estimate, least_squares, spec);
    let r = context.norm_limit(context.norm_of(&estimate.coefficients), warnings);
    let bounds = bias::per_coefficient(&estimate.directions, &filtered, r);
    let sharp = if dropped > 0 { r } else { 0.0 };
    Ok(Applied {
        residuals,
        rss,
        spectrum: RegularizedSpectrum {
            eigenvalues: filtered.iter().map(|f| f.eigenvalue).collect(),
            condition: condition(lambda[dropped..].iter().copied()),
            log10_determinant: super::report::log10_determinant(filtered.iter().map(|f| f.eigenvalue)),
        },
        regularization: RegularizationReport {
            rank: Some(rank),
            filter_factors: filtered.iter().map(|f| f.factor).collect(),
            choices,
            ..report(RegularizationKind::TruncatedSvd)
        },
        bias: context.bias(standing.bias_norm, sharp, r),
        bounds,
        curve: None,
        trace: None,
        matrix_b: None,
        matrix_b_factors: None,
        // the subspace that is kept turns with the nodes: the bounds for X + B say nothing of it
        after: None,
        map: LinearMap::Eigenvectors { removed: filtered.iter().map(|f| f.removed).collect() },
        prior: None,
        constraints: None,
        representative: None,
        estimate,
    })
}
