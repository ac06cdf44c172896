//! Prior of the coefficients: a given mean and spread, or the chain of earlier measurements of a
//! flank that moved in between.
//!
//! Everything is said along the columns of the nodes of now, from their least squares and in units
//! of σ: the coefficients are `A = Â + σ U⁻¹ δ`, U the columns in Q's coordinates. There the nodes
//! of now say `δ = 0` with covariance 1, whatever the basis and its scaling, and a move that
//! spreads by q standard errors of least squares, `Q = q²σ²(XᵀX)⁻¹`, has covariance q². Earlier
//! nodes say `U_k U⁻¹ δ = (Q_kᵀY_k − U_k Â)/σ`.
//!
//! The move of the flank is unknown: the posterior is the mixture over q with the likelihood as
//! weights, reported by its mean and covariance. A flank that moved little for long may have moved
//! once since (a new tool, another clamping), of which the moves before say nothing: with the share
//! [`STEP`] the last move is a step of any size in addition. A prior that the nodes contradict is
//! dropped.

mod chain;
mod conflict;
mod current;
mod form_interval;
mod information;
mod mixture;
mod noise;
mod observe;

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use self::{
    chain::{Branch, Link, ln_sum, median, ratios, steps, weights},
    information::{Information, Spread},
    observe::Observed,
};
use super::{
    data::Nodes,
    design::Design,
    error::FitError,
    result::{PriorConflict, Warning},
    spec::{Chain, Earlier, Estimator, FitSpec, Moves, Prior, PriorSpread, Regularization, Scaling},
};
use flankfit_numerics::{
    check::Faults,
    words::{Shown, counted, entries},
};

pub(crate) use self::{
    current::{Current, PooledNoise},
    form_interval::FormIntervals,
    mixture::Mixture,
};

/// Number of earlier iterations from which on the size of moves is known before the last.
const JUDGED_FROM: usize = 2;

/// Earlier iterations times the cube of the coefficients: some seconds of work.
const MOST_WORK: usize = 20_000_000;

/// The probability beforehand that the last move was a step.
const STEP: f64 = 0.2;

/// Result of applying a prior.
pub(crate) struct Outcome {
    pub noise: PooledNoise,
    pub conflict: Option<PriorConflict>,
    /// Root mean square of q, where moves were estimated.
    pub ratio: Option<f64>,
    /// Posterior; `None` if the prior was dropped.
    pub posterior: Option<Mixture>,
    /// Parts of the intervals, if moves were estimated.
    pub intervals: Option<Arc<FormIntervals>>,
    /// Present where σ of now and before are not the same.
    pub unequal: Option<Warning>,
}

/// Refuses requests that a prior excludes, and a prior that does not suit the model.
pub(crate) fn check(design: &Design, spec: &FitSpec) -> Result<(), Faults> {
    let Some(prior) = &spec.prior else { return Ok(()) };
    let mut faults = Faults::default();
    if spec.regularization != Regularization::None {
        faults.push("regularization", "a `prior` excludes regularisation: omit `regularization`, or use `none`");
    }
    if spec.estimator != Estimator::LeastSquares {
        faults.push("estimator", "a `prior` needs the estimator `least_squares`");
    }
    if spec.scaling == Scaling::Standardized {
        faults.push(
            "scaling",
            "a `prior` covers all coefficients including the constant, which `standardized` \
            excludes",
        );
    }
    if spec.coefficient_norm_limit.is_some() {
        faults.push(
            "coefficient_norm_limit",
            "the `prior` already limits the coefficients: omit the limit of their norm",
        );
    }
    let n = design.size();
    let mut count = |path: &str, given: usize| {
        let right = given == n;
        if !right {
            faults.push(
                path,
                format_args!(
                    "{}; the model has {}, in the order of the result",
                    entries(given),
                    counted(n, "coefficient", "coefficients")
                ),
            );
        }
        right
    };
    match prior {
        Prior::Given { mean, spread } => {
            count("prior.mean", mean.len());
            match spread {
                PriorSpread::StdError(deviations) => {
                    count("prior.std_error", deviations.len());
                    positive(deviations, "prior.std_error", &mut faults);
                }
                PriorSpread::Covariance(triangle) => {
                    count("prior.covariance", triangle.len());
                    for (row, numbers) in triangle.iter().enumerate() {
                        match numbers.get(row) {
                            Some(variance) if numbers.len() == row + 1 => {
                                if !(*variance > 0.0 && variance.is_finite()) {
                                    faults.push("prior.covariance", observe::NOT_POSITIVE);
                                }
                            }
                            _ => faults.push(
                                format_args!("prior.covariance[{row}]"),
                                format_args!(
                                    "row {row} of a lower triangle has {}; this one has {}",
                                    counted(row + 1, "number", "numbers"),
                                    numbers.len()
                                ),
                            ),
                        }
                    }
                }
            }
        }
        Prior::Iterations(chain) => {
            if let Moves::StdError(deviations) = &chain.moves {
                count("prior.move", deviations.len());
                positive(deviations, "prior.move", &mut faults);
            }
            let most = MOST_WORK / n.pow(3).max(1);
            match chain.earlier.as_ref().map(|earlier| earlier.len()) {
                None => faults.push(
                    "prior.iterations",
                    "only a fit in a job has earlier iterations: give `mean` with `std_error` or `covariance`",
                ),
                Some(iterations) if iterations > most => {
                    let reason =
                        format!("{iterations} earlier iterations are too many for {n} coefficients: at most {most}");
                    faults.push("prior.iterations", reason);
                }
                Some(_) => {}
            }
        }
    }
    faults.into_result(())
}

fn positive(deviations: &[f64], list: &str, faults: &mut Faults) {
    for (j, &deviation) in deviations.iter().enumerate().filter(|(_, d)| !(**d > 0.0 && d.is_finite())) {
        faults.push(
            format_args!("{list}[{j}]"),
            format_args!("{} is not a standard deviation: it must be above 0", Shown(deviation)),
        );
    }
}

/// Weighs the prior of the spec against the nodes of now; `None` for a chain without iterations.
pub(crate) fn weigh(current: &Current, prior: &Prior) -> Result<Option<Outcome>, FitError> {
    let n = current.coefficients.len();
    let now = Information { r: DMatrix::identity(n, n), d: DVector::zeros(n) };
    let mut unequal = None;
    let (noise, branches, estimated) = match prior {
        Prior::Given { mean, spread } => {
            let noise = noise::pooled(current, &[])?;
            let known = observe::given(mean, spread, current, noise.sigma)?;
            (noise, vec![Branch::of(known, &now)], None)
        }
        Prior::Iterations(chain) => {
            let Some(earlier) = chain.earlier.as_deref().filter(|earlier| !earlier.is_empty()) else {
                return Ok(None);
            };
            let observed = Observed::all(chain, earlier, current)?;
            let noise = noise::pooled(current, &observed)?;
            unequal = noise::unequal(current, &observed);
            let links: Vec<Link> = observed.iter().map(|one| one.link(noise.sigma)).collect();
            let follow = |spread: &Spread| Branch::follow(&links, &now, spread).ok_or_else(observe::undetermined);
            match &chain.moves {
                Moves::StdError(deviations) => {
                    let branch = follow(&Spread::Of(current.along(deviations, noise.sigma)));
                    // what is determined without a move is so with any that doubles hold
                    let lost = || follow(&Spread::Even(0.0)).is_ok();
                    let branch = branch.map_err(|undetermined| match lost() {
                        true => exceeds_double_at("prior.move"),
                        false => undetermined,
                    })?;
                    (noise, vec![branch], None)
                }
                Moves::Estimated => {
                    let sizes: Vec<f64> = ratios().collect();
                    let branches: Result<Vec<_>, _> = sizes.iter().map(|&q| follow(&Spread::Even(q))).collect();
                    let branches = branches?;
                    let stepped = stepped(&links, &branches, &sizes, &now);
                    let intervals = Arc::new(FormIntervals::new(noise.sigma, &links, &branches, &sizes, &stepped));
                    (noise, branches, Some((sizes, intervals, stepped, links.len() >= JUDGED_FROM)))
                }
            }
        }
    };
    let conflict = match &estimated {
        // one move is compared with the largest admissible one
        Some((_, _, stepped, false)) => Some(conflict::conflict(stepped, noise.freedom)).filter(|found| found.dropped),
        _ => Some(conflict::conflict(&branches, noise.freedom)),
    };
    let (ratio, intervals, mixture) = match estimated {
        None => (None, None, Mixture::new(branches.iter().map(|branch| (branch, branch.ln_all)))),
        Some((sizes, intervals, stepped, _)) => {
            let weights = weights(branches.iter().map(|branch| branch.ln_all));
            let square: f64 = sizes.iter().zip(weights).map(|(q, weight)| weight * q * q).sum();
            let even = branches.iter().map(|branch| (branch, branch.ln_all + libm::log(1.0 - STEP)));
            let each = libm::log(STEP / steps().len() as f64);
            let aside = stepped.iter().map(|branch| (branch, branch.ln_all + each));
            (Some(square.sqrt()), Some(intervals), Mixture::new(even.chain(aside)))
        }
    };
    if !mixture.is_finite() {
        return Err(exceeds_double(prior));
    }
    let posterior = Some(mixture).filter(|_| !conflict.is_some_and(|found| found.dropped));
    Ok(Some(Outcome { noise, conflict, ratio, posterior, intervals, unequal }))
}

/// Branches with a step in the last move, starting from the median of the sizes that the earlier
/// moves support.
fn stepped(links: &[Link], branches: &[Branch], sizes: &[f64], now: &Information) -> Vec<Branch> {
    let earlier = || branches.iter().map(|branch| branch.ln_earlier);
    let middle = sizes[median(weights(earlier()).into_iter())];
    Branch::steps(links, now, middle, ln_sum(earlier()))
}

/// Error for a prior whose effect next to these nodes exceeds doubles.
pub(crate) fn exceeds_double(prior: &Prior) -> FitError {
    let path = match prior {
        Prior::Given { spread: PriorSpread::StdError(_), .. } => "prior.std_error",
        Prior::Given { spread: PriorSpread::Covariance(_), .. } => "prior.covariance",
        Prior::Iterations(_) => "prior.iterations",
    };
    FitError::ExceedsDouble(exceeds_double_at(path))
}

fn exceeds_double_at(path: &str) -> Faults {
    let message = "prior and nodes differ too much, in value or in precision, for double precision";
    Faults::one(path, message)
}

/// The spec with its earlier nodes changed by `change`, like the present ones.
pub(crate) fn with_earlier(
    spec: &FitSpec,
    change: impl Fn(&Nodes) -> Result<Nodes, FitError>,
) -> Result<Option<FitSpec>, FitError> {
    let Some(Prior::Iterations(chain @ Chain { earlier: Some(earlier), .. })) = &spec.prior else { return Ok(None) };
    let changed = |one: &Earlier| Ok::<_, FitError>(Earlier { nodes: Arc::new(change(&one.nodes)?), ..one.clone() });
    let earlier: Vec<Earlier> = earlier.iter().map(changed).collect::<Result<_, _>>()?;
    let chain = Chain { earlier: Some(earlier.into()), ..chain.clone() };
    Ok(Some(FitSpec { prior: Some(Prior::Iterations(chain)), ..spec.clone() }))
}
