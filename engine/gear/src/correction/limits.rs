//! Settings at their limits: an active set over fits.
//!
//! What is answered is settled when it is a fixed point of the fits: the free settings are the fit
//! of what the settings at their limits leave over, they keep their own limits, and every setting
//! at a limit, freed while the others stay, would be driven past it again. For plain least squares
//! the last is the condition of Karush, Kuhn and Tucker (a freed setting moves against the sign of
//! its multiplier), so that the answer is the minimum within the limits; for regularised fits it
//! says the same with each fit's own λ*. Each round moves from a point within the limits towards
//! the fit of the free settings and stops at the first limit in the way, or frees a setting that
//! would come back (Lawson and Hanson; Stark and Parker). Rounds are bounded, and where regularised
//! fits do not settle the best point seen is answered, which the answer says.

use super::{
    damping::{self, Damping, Trust},
    problem::{Correction, CorrectionSpec, Setting},
};
use flankfit_estimation::{
    FitError, FitResult, FitSpec, Nodes, Unconverged, fit,
    spec::{Attraction, Count, ExpectedSize, JamesStein, Model, Regularization},
};
use flankfit_numerics::cancel;

/// Limit that a setting was stopped at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Limit {
    /// The least change allowed.
    Min,
    /// The greatest change allowed.
    Max,
}

/// Rounds for each setting, at most.
const ROUNDS: usize = 8;
/// How far, against the setting's changes at large, a freed setting must come back to be freed.
const TOLERANCE: f64 = 1e-10;

/// A fit of some settings, the others being given.
pub(super) struct Fitted {
    pub result: FitResult,
    pub trust: Option<Trust>,
}

/// Positions of the settings.
pub(super) struct Standing {
    pub change: Vec<f64>,
    pub at: Vec<Option<Limit>>,
    /// The fit of the free settings; `None` when every setting is at a limit.
    pub fitted: Option<Fitted>,
    pub settled: bool,
}

/// Positions of the settings when those that are `pinned` are changed by that much. `unlimited`
/// is the fit of the others without limits; no fit is returned where that is within them.
pub(super) fn positions(
    correction: &Correction,
    unlimited: &[f64],
    pinned: &[Option<f64>],
) -> Result<Standing, FitError> {
    let settings = &correction.spec().settings;
    let inside = (0..unlimited.len()).all(|j| {
        pinned[j].is_some()
            || settings[j].min.is_none_or(|min| min <= unlimited[j])
                && settings[j].max.is_none_or(|max| unlimited[j] <= max)
    });
    match inside {
        true => {
            Ok(Standing { change: unlimited.to_vec(), at: vec![None; unlimited.len()], fitted: None, settled: true })
        }
        false => within(correction, unlimited, pinned),
    }
}

/// The change of a setting that the deviations say nothing about: none, or the least that its
/// limits and its increment allow.
pub(super) fn least_change(setting: &Setting) -> f64 {
    let nearest = |least: f64, most: f64| 0f64.max(least).min(most);
    match (setting.increment, setting.steps()) {
        (Some(increment), Some([least, most])) => Setting::multiple(nearest(least, most), increment),
        _ => nearest(setting.min.unwrap_or(f64::NEG_INFINITY), setting.max.unwrap_or(f64::INFINITY)),
    }
}

/// Fits the settings `free` to what the others, changed by `change`, leave over.
pub(super) fn fit_free(correction: &Correction, free: &[usize], change: &[f64]) -> Result<Fitted, FitError> {
    let asked = correction.spec();
    let held: Vec<f64> = (0..change.len()).map(|j| if free.contains(&j) { 0.0 } else { change[j] }).collect();
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for &k in correction.counted() {
        let row = correction.row(k);
        x.extend(free.iter().map(|&j| row[j]));
        y.push(-correction.left_at(k, &held));
    }
    let weight = asked.weight.as_ref().map(|w| correction.counted().iter().map(|&k| w[k]).collect::<Vec<f64>>());
    let square: f64 = y.iter().enumerate().map(|(i, y)| weight.as_ref().map_or(1.0, |w| w[i]) * y * y).sum();
    let names = free.iter().map(|&j| asked.settings[j].name.clone()).collect();
    let nodes = Nodes::matrix(x, free.len(), y, Some(names), weight).map_err(|faults| faults.within("nodes"))?;
    let spec = FitSpec {
        scaling: asked.scaling,
        noise_sigma: asked.noise_sigma,
        coefficient_norm_limit: asked.coefficient_norm_limit,
        include: asked.include,
        ..FitSpec::new(Model::Linear)
    };
    match &asked.damping {
        Damping::Given(regularization) => {
            let regularization = among(regularization, free, change.len());
            Ok(Fitted { result: fit(&nodes, &FitSpec { regularization, ..spec })?, trust: None })
        }
        Damping::Uncertainty => {
            let spec = FitSpec { expected_size: expected(asked, free), ..spec };
            let plain = fit(&nodes, &FitSpec { regularization: Regularization::None, ..spec.clone() })?;
            let trust = damping::trust(&plain, square, asked.response_uncertainty, asked.noise_sigma);
            let regularization = damping::regularization(&plain, trust);
            let result = match regularization {
                Regularization::None => plain,
                regularization => fit(&nodes, &FitSpec { regularization, ..spec })?,
            };
            Ok(Fitted { result, trust })
        }
    }
}

/// How large the changes of the settings `free` are taken to be: as large as they may be where all
/// of them have limits, else as the deviations speak for. Not as plain least squares makes them,
/// which lets those that cannot be distinguished run away.
fn expected(asked: &CorrectionSpec, free: &[usize]) -> ExpectedSize {
    let furthest = |j: &usize| {
        let Setting { min, max, .. } = &asked.settings[*j];
        Some(min.as_ref()?.abs().max(max.as_ref()?.abs()))
    };
    free.iter().map(furthest).collect::<Option<Vec<f64>>>().map_or(ExpectedSize::OfHeights, ExpectedSize::Within)
}

/// The caller's regularisation for some of the settings: targets lose the entries of the others,
/// and of so many directions or eigenvalues there are at most as many as there are.
fn among(regularization: &Regularization, free: &[usize], all: usize) -> Regularization {
    let of = |target: &Vec<f64>| match target.len() == all {
        true => free.iter().map(|&j| target[j]).collect(),
        false => target.clone(),
    };
    if free.len() == all {
        return regularization.clone();
    }
    match regularization.clone() {
        Regularization::Spectral { scheme, count: Count::Given(count), condition_limit, lambda_star } => {
            let count = Count::Given(count.min(free.len() - 1));
            Regularization::Spectral { scheme, count, condition_limit, lambda_star }
        }
        Regularization::TruncatedSvd { rank } => Regularization::TruncatedSvd { rank: rank.min(free.len()) },
        // fewer than three directions pay for no factor
        Regularization::JamesStein(_) if free.len() < 3 => Regularization::None,
        Regularization::JamesStein(asked) => {
            Regularization::JamesStein(JamesStein { target: asked.target.as_ref().map(of), ..asked })
        }
        Regularization::Attraction(asked) => {
            Regularization::Attraction(Attraction { target: of(&asked.target), ..asked })
        }
        other => other,
    }
}

/// From the fit without limits to settings within them.
fn within(correction: &Correction, unlimited: &[f64], pinned: &[Option<f64>]) -> Result<Standing, FitError> {
    let settings = &correction.spec().settings;
    let n = settings.len();
    let low = |j: usize| pinned[j].or(settings[j].min).unwrap_or(f64::NEG_INFINITY);
    let high = |j: usize| pinned[j].or(settings[j].max).unwrap_or(f64::INFINITY);
    // nothing changed is where to start from, or as near to it as the limits allow
    let mut point: Vec<f64> = (0..n).map(|j| 0f64.max(low(j)).min(high(j))).collect();
    let mut at: Vec<Option<Limit>> = vec![None; n];
    let mut seen: Vec<Vec<Option<Limit>>> = Vec::new();
    let mut best: Option<(f64, Standing)> = None;
    let mut goal = unlimited.to_vec();
    let mut fitted = None;
    for _ in 0..ROUNDS * n + ROUNDS {
        cancel::checkpoint();
        let first = (0..n)
            .filter(|&j| at[j].is_none() && pinned[j].is_none())
            .filter_map(|j| {
                let (limit, end) = match goal[j] {
                    x if x < low(j) => (Limit::Min, low(j)),
                    x if x > high(j) => (Limit::Max, high(j)),
                    _ => return None,
                };
                let way = (end - point[j]) / (goal[j] - point[j]);
                Some((way.clamp(0.0, 1.0), j, limit, end))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((way, j, limit, end)) = first {
            for i in 0..n {
                if at[i].is_none() {
                    point[i] = (point[i] + way * (goal[i] - point[i])).max(low(i)).min(high(i));
                }
            }
            (point[j], at[j]) = (end, Some(limit));
        } else {
            point.clone_from(&goal);
            let freed = coming_back(correction, &at, &point, pinned)?;
            let repeated = seen.contains(&at);
            let standing = Standing { change: point.clone(), at: at.clone(), fitted: fitted.take(), settled: true };
            let Some(j) = freed else { return Ok(standing) };
            let left = remaining(correction, &point);
            if best.as_ref().is_none_or(|(least, _)| left < *least) {
                best = Some((left, Standing { settled: false, ..standing }));
            }
            if repeated {
                break;
            }
            seen.push(at.clone());
            at[j] = None;
        }
        let free: Vec<usize> = (0..n).filter(|&j| at[j].is_none() && pinned[j].is_none()).collect();
        goal.clone_from(&point);
        fitted = match free.is_empty() {
            true => None,
            false => {
                let of_free = fit_free(correction, &free, &point)?;
                for (&j, coefficient) in free.iter().zip(&of_free.result.coefficients) {
                    goal[j] = coefficient.value;
                }
                Some(of_free)
            }
        };
    }
    match best {
        Some((_, standing)) => Ok(standing),
        None => Err(FitError::NotConverged(Unconverged::Limits)),
    }
}

/// A setting at a limit that, freed, would come back inside. Those that the remaining deviations
/// pull inwards most are asked first; for plain least squares the first of them does come back.
fn coming_back(
    correction: &Correction,
    at: &[Option<Limit>],
    point: &[f64],
    pinned: &[Option<f64>],
) -> Result<Option<usize>, FitError> {
    let mut pulls: Vec<(f64, usize, Limit)> = pull(correction, point)
        .into_iter()
        .enumerate()
        .filter_map(|(j, pull)| match at[j]? {
            Limit::Min => Some((pull, j, Limit::Min)),
            Limit::Max => Some((-pull, j, Limit::Max)),
        })
        .collect();
    pulls.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (_, j, limit) in pulls {
        cancel::checkpoint();
        let free: Vec<usize> = (0..at.len()).filter(|&i| i == j || (at[i].is_none() && pinned[i].is_none())).collect();
        let fitted = fit_free(correction, &free, point)?;
        let value =
            free.iter().zip(&fitted.result.coefficients).find(|(i, _)| **i == j).map_or(point[j], |(_, c)| c.value);
        let inward = match limit {
            Limit::Min => value - point[j],
            Limit::Max => point[j] - value,
        };
        if inward > TOLERANCE * value.abs().max(point[j].abs()) {
            return Ok(Some(j));
        }
    }
    Ok(None)
}

/// How much the remaining deviations ask for more of each setting: −Jᵀ W (d + JΔ − t), for columns
/// of length 1.
fn pull(correction: &Correction, change: &[f64]) -> Vec<f64> {
    let n = change.len();
    let (mut sums, mut squares) = (vec![0.0; n], vec![0.0; n]);
    for &k in correction.counted() {
        let (row, w) = (correction.row(k), correction.weight(k));
        let left = correction.left_at(k, change);
        for j in 0..n {
            sums[j] -= w * row[j] * left;
            squares[j] += w * row[j] * row[j];
        }
    }
    sums.iter().zip(&squares).map(|(sum, square)| sum / square.sqrt()).collect()
}

/// Σ w (d + JΔ − t)².
fn remaining(correction: &Correction, change: &[f64]) -> f64 {
    let square = |k: &usize| correction.weight(*k) * correction.left_at(*k, change).powi(2);
    correction.counted().iter().map(square).sum()
}
