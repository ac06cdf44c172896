//! Knots placed by residuals: start coarse, and give every span that misses the tolerance one more
//! knot, until none does.
//!
//! The knot goes where half of the span's squared error lies to its left, midway between two
//! parameters, and leaves two parameters at least on either side of it. There are clearly fewer
//! control points than parameters, and the condition of Schoenberg and Whitney holds (every basis
//! function has a parameter of its own inside its support), so that X keeps its full rank. Spans
//! that miss by most come first when not all of them can have a knot.
//!
//! Points determine nothing of the curve between them. A round whose curve oscillates there by more
//! than the extent of all points is not taken; of the others the one with the least error is
//! returned.

use super::{
    settings::Adaptive,
    swing::{Swing, WILD},
    trial::{Fitted, Trial, summary, uniform},
};
use crate::{
    design::MOST_COEFFICIENTS,
    error::{FitError, Unconverged},
    spec::Knots,
};
use flankfit_geometry::BSplineBasis;
use flankfit_numerics::{
    cancel::{self, Asking},
    check::Faults,
};

/// Rounds at most.
const MOST_STEPS: usize = 64;
/// A span is not divided into parts narrower than this, relative to the domain.
const NARROWEST: f64 = 1e-9;
/// Distinct parameters that a span keeps at least.
const LEAST_IN_SPAN: usize = 2;
/// Control points for each distinct parameter at most, in addition to the initial knots.
const CROWDED: f64 = 0.75;

/// One round.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The full knot vector.
    pub knots: Vec<f64>,
    /// Largest distance of a counted point from the curve, at its parameter.
    pub max_error: f64,
    /// Root mean square of these distances.
    pub rms_error: f64,
}

/// Reason why no more knots were tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// No point is further away than the tolerance.
    Tolerance,
    /// The greatest number of control points is reached.
    MostControls,
    /// No span that misses the tolerance can take a knot: it has too few parameters, or with a knot
    /// the curve oscillates between the points.
    TooFewPoints,
    /// The greatest number of rounds is reached.
    MostSteps,
}

/// Places knots over `domain`; the best fit found, the rounds up to it, and why they ended.
pub(super) fn place(trial: &Trial, asked: &Adaptive, domain: [f64; 2]) -> Result<(Fitted, Vec<Step>, Stop), FitError> {
    let degree = trial.asked.degree;
    let mut faults = Faults::default();
    if !(asked.tolerance > 0.0 && asked.tolerance.is_finite()) {
        faults.push("method.tolerance", "a finite length greater than 0");
    }
    if asked.most_controls > MOST_COEFFICIENTS || asked.most_controls < asked.spans.saturating_add(degree) {
        faults.push(
            "method.most_control_points",
            format_args!("not within {} (the first knots) and {MOST_COEFFICIENTS}", asked.spans.saturating_add(degree)),
        );
    }
    faults.into_result(())?;
    let weight = trial.points.weight;
    let mut sorted: Vec<f64> = (0..trial.parameters.len())
        .filter(|&k| weight.is_none_or(|w| w[k] > 0.0))
        .map(|k| trial.parameters[k])
        .collect();
    sorted.sort_by(cancel::comparing(f64::total_cmp));
    sorted.dedup();
    let swing = Swing::of(trial.points, &sorted);
    let domain = trial.asked.spec.domain.and_then(|domain| domain.u).unwrap_or(domain);
    let mut basis = uniform(degree, asked.spans, domain)?;
    let room = ((CROWDED * sorted.len() as f64) as usize).max(basis.size());
    let mut steps = Vec::new();
    let mut best: Option<(Fitted, usize)> = None;
    let mut stop = Stop::MostSteps;
    for round in 0..MOST_STEPS {
        cancel::checkpoint();
        let fitted = match (trial.fit(Knots::Curve(basis.knots().to_vec())), &best) {
            (Ok(fitted), _) => fitted,
            // knots that cannot be fitted cannot be taken
            (Err(_), Some(_)) => {
                stop = Stop::TooFewPoints;
                break;
            }
            (Err(error), None) => return Err(error),
        };
        if round > 0 && swing.out(&trial.shape(&fitted)?) > WILD {
            stop = Stop::TooFewPoints;
            break;
        }
        let (max_error, rms_error) = summary(&fitted.errors);
        steps.push(Step { knots: basis.knots().to_vec(), max_error, rms_error });
        let next = if max_error <= asked.tolerance {
            stop = Stop::Tolerance;
            None
        } else if basis.size() >= asked.most_controls {
            stop = Stop::MostControls;
            None
        } else {
            let next = refined(trial, asked, &basis, &fitted, &sorted, room);
            if next.is_none() {
                stop = Stop::TooFewPoints;
            }
            next
        };
        if best.as_ref().is_none_or(|(_, at)| max_error < steps[*at].max_error) {
            best = Some((fitted, round));
        }
        match next {
            Some(next) => basis = next,
            None => break,
        }
    }
    match best {
        Some((fitted, at)) => {
            steps.truncate(at + 1);
            Ok((fitted, steps, stop))
        }
        None => Err(FitError::NotConverged(Unconverged::KnotPlacement)),
    }
}

/// Adds a knot in every span that misses the tolerance, or next to it, up to `room` control points;
/// `None` if none can take one.
fn refined(
    trial: &Trial,
    asked: &Adaptive,
    basis: &BSplineBasis,
    fitted: &Fitted,
    sorted: &[f64],
    room: usize,
) -> Option<BSplineBasis> {
    let breaks = basis.distinct_knots();
    let mut spans: Vec<Vec<(f64, f64)>> = vec![Vec::new(); breaks.len() - 1];
    for &(k, error) in fitted.errors.iter().asking(50) {
        let t = trial.parameters[k];
        let span = breaks.partition_point(|&b| b <= t).clamp(1, spans.len()) - 1;
        spans[span].push((t, error));
    }
    let worst = |points: &[(f64, f64)]| points.iter().map(|point| point.1).fold(0.0, f64::max);
    let mut missing: Vec<(f64, usize)> = spans
        .iter()
        .enumerate()
        .map(|(s, points)| (worst(points), s))
        .filter(|(error, _)| *error > asked.tolerance)
        .collect();
    missing.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let narrowest = NARROWEST * (breaks[breaks.len() - 1] - breaks[0]);
    let mut current = basis.clone();
    let mut divided = vec![false; spans.len()];
    for (_, span) in missing {
        if current.size() >= asked.most_controls.min(room) {
            break;
        }
        // a span that can take no knot itself gains from a knot in one that shares functions with
        // it: the nearest, and then the wider one
        let width = |s: usize| breaks[s + 1] - breaks[s];
        let reach = basis.degree().max(1);
        let mut beside: Vec<usize> = (span.saturating_sub(reach)..spans.len().min(span + reach + 1)).collect();
        beside.retain(|&s| s != span);
        beside.sort_by(|&a, &b| a.abs_diff(span).cmp(&b.abs_diff(span)).then(width(b).total_cmp(&width(a))));
        for target in std::iter::once(span).chain(beside) {
            if divided[target] {
                // it has its knot of this round
                if target == span {
                    break;
                }
                continue;
            }
            let ends = [breaks[target], breaks[target + 1]];
            if let Some(next) = divide(&current, ends, narrowest, &mut spans[target], sorted) {
                divided[target] = true;
                current = next;
                break;
            }
        }
    }
    (current.size() > basis.size()).then_some(current)
}

/// Adds a knot in the span between `ends`, whose points have these errors; `None` if it can take
/// none.
fn divide(
    current: &BSplineBasis,
    ends: [f64; 2],
    narrowest: f64,
    points: &mut [(f64, f64)],
    sorted: &[f64],
) -> Option<BSplineBasis> {
    let middle = 0.5 * ends[0] + 0.5 * ends[1];
    let has_room = |place: f64| {
        let before = |t: f64| sorted.partition_point(|&s| s < t);
        // a parameter at the end of the domain belongs to the last span
        let last = if ends[1] >= current.domain().1 { sorted.len() } else { before(ends[1]) };
        let (first, here) = (before(ends[0]), before(place));
        here >= first + LEAST_IN_SPAN && last >= here + LEAST_IN_SPAN
    };
    let place = halving(points).map(|place| within(place, ends, sorted));
    let places = [place, Some(middle), Some(within(middle, ends, sorted))];
    places.into_iter().flatten().find_map(|place| {
        cancel::checkpoint();
        if !(place - ends[0] > narrowest && ends[1] - place > narrowest && has_room(place)) {
            return None;
        }
        let mut knots = current.knots().to_vec();
        knots.insert(knots.partition_point(|&k| k <= place), place);
        let next = BSplineBasis::new(current.degree(), knots).ok()?;
        schoenberg_whitney(&next, sorted).then_some(next)
    })
}

/// The place nearest to `place` between two parameters that leaves as many as a span keeps on
/// either side; `place` where there is none.
fn within(place: f64, ends: [f64; 2], sorted: &[f64]) -> f64 {
    let [first, last] = [sorted.partition_point(|&t| t < ends[0]), sorted.partition_point(|&t| t <= ends[1])];
    let (low, high) = (first + LEAST_IN_SPAN, last.saturating_sub(LEAST_IN_SPAN));
    let here = sorted.partition_point(|&t| t < place);
    if low > high || (low..=high).contains(&here) || high == 0 || high >= sorted.len() {
        return place;
    }
    let at = here.clamp(low, high);
    0.5 * sorted[at - 1] + 0.5 * sorted[at]
}

/// Midway between the two parameters where the squared error to the left reaches half.
fn halving(points: &mut [(f64, f64)]) -> Option<f64> {
    points.sort_by(cancel::comparing(|a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0)));
    let half = 0.5 * points.iter().map(|(_, e)| e * e).sum::<f64>();
    let mut sum = 0.0;
    let at = points.iter().position(|(_, e)| {
        sum += e * e;
        sum >= half
    })?;
    let here = points[at].0;
    let next = points[at..].iter().find(|point| point.0 > here).or(points[..at].iter().rev().find(|p| p.0 < here))?;
    Some(0.5 * here + 0.5 * next.0)
}

/// True if every function can be given a parameter of its own inside its support, in ascending
/// order.
pub(super) fn schoenberg_whitney(basis: &BSplineBasis, ascending: &[f64]) -> bool {
    let (knots, p) = (basis.knots(), basis.degree());
    let (low, high) = basis.domain();
    let mut next = 0;
    for i in 0..basis.size() {
        let (start, end) = (knots[i], knots[i + p + 1]);
        // the ends of the domain belong to the functions that are not 0 there
        let opens = |t: f64| t > start || (t == low && knots[i + p] == low);
        let closes = |t: f64| t < end || (t == high && knots[i + 1] == high);
        while ascending.get(next).is_some_and(|&t| !opens(t)) {
            next += 1;
        }
        match ascending.get(next) {
            // repeated parameters are one
            Some(&t) if closes(t) => {
                next += ascending[next..].iter().asking(1).take_while(|&&other| other == t).count()
            }
            _ => return false,
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_condition_of_schoenberg_and_whitney() {
        let basis = BSplineBasis::new(1, vec![0., 0., 1., 2., 2.]).unwrap();
        assert!(schoenberg_whitney(&basis, &[0.0, 0.5, 2.0]));
        assert!(schoenberg_whitney(&basis, &[0.1, 0.5, 1.5]));
        // nothing inside the last function's support but where the one before it needs it
        assert!(!schoenberg_whitney(&basis, &[0.0, 0.5, 0.7, 1.0]));
        assert!(!schoenberg_whitney(&basis, &[0.0, 0.0, 2.0]));
    }

    #[test]
    fn half_of_the_error_lies_left() {
        assert_eq!(halving(&mut [(3.0, 1.0), (0.0, 1.0), (1.0, 1.0), (2.0, 0.0)]), Some(1.5));
        assert_eq!(halving(&mut [(0.0, 1.0), (1.0, 5.0)]), Some(0.5));
        assert_eq!(halving(&mut [(2.0, 1.0), (2.0, 5.0)]), None);
    }
}
