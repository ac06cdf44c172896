//! Samples that stand out of their neighbours: dust, chips, a probe that lifted off.
//!
//! Short places, up to a sixteenth of the trace, are looked for here, and long ones within it, up
//! to a seventh, by [`wide`]. Ends are compared with those of the other traces of a flank by
//! [`burrs`].
//!
//! A smooth curve through medians (the mean parabola taken away, then medians of blocks with
//! straight lines between them) leaves residuals. A sample is suspected where its residual is more
//! than [`THRESHOLD`] times the scale (1.4826 × median absolute deviation) of the whole trace *and*
//! of its own neighbourhood, about the neighbourhood's median (Hampel's rule with a window), and
//! where the trace comes back behind it. At an end it cannot come back: there a place is suspected
//! where material protrudes and begins abruptly. What falls off to the end is a relief or a break
//! of the edge, and what rises slowly is the flank. The standard counts such samples, and so does
//! the evaluation unless they are asked to be left out; but it says so.

pub(super) mod burrs;
mod wide;

use super::{mean_curve::MeanCurves, missing::missing};
use flankfit_numerics::{cancel::Asking, quantiles::median};

/// Multiples of the scale.
pub const THRESHOLD: f64 = 6.0;
/// Skirts of a suspected place go with it while they stand out by so many scales.
const SKIRT: f64 = 2.5;
/// No scale is finer, µm: traces are rounded numbers.
const FINEST: f64 = 0.1;
/// Fewest samples of which any can be suspected.
const FEWEST: usize = 20;
/// Most samples of a block; a place of dust is at most half as long.
const LONGEST_BLOCK: usize = 50;
/// At the ends of a trace a place begins within one in so many of its samples.
const ABRUPT_AT_ENDS: usize = 60;
/// Over one in so many samples there the trace rises by this share of the height more than before.
const STEP_AT_ENDS: usize = 120;
const LEAST_STEP: f64 = 0.5;
/// One in so many samples of a trace lies next to a border, and so many at least.
const BESIDE: usize = 12;
const FEWEST_BESIDE: usize = 8;
/// At a border the trace jumps by this share of the height, and by so many scatters about the curve
/// next to it.
const LEAST_JUMP: f64 = 0.5;
const JUMP_OVER_RMS: f64 = 4.0;
/// Normal standard deviation over median absolute deviation.
const MAD: f64 = 1.482_602_218_505_602;

/// Neighbouring samples that stand out, by their places in the ascending trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Run {
    pub from: usize,
    /// The first behind it.
    pub to: usize,
    /// Greatest residual, with its sign, in the unit of the deviations.
    pub height: f64,
    /// True if it protrudes at an end where most other traces of the flank do not.
    pub burr: bool,
}

/// The suspected places of a trace with samples at ascending `at`; all defined.
pub(crate) fn outliers(at: &[f64], deviation: &[f64]) -> Vec<Run> {
    let parts = parts(at);
    let is_cut = parts.len() > 1;
    let placed = |[from, to]: [usize; 2]| {
        let of_part = of_part(&at[from..to], &deviation[from..to], is_cut);
        of_part.into_iter().map(move |run| Run { from: from + run.from, to: from + run.to, ..run })
    };
    parts.into_iter().flat_map(placed).collect()
}

/// First samples, and their ends, of the parts of a trace between missing samples.
fn parts(at: &[f64]) -> Vec<[usize; 2]> {
    // several samples may lie at one place
    let first: Vec<usize> = (0..at.len()).filter(|&i| i == 0 || at[i] > at[i - 1]).collect();
    let distances: Vec<f64> = first.windows(2).map(|pair| at[pair[1]] - at[pair[0]]).collect();
    let lost = missing(&distances, distances.iter().sum());
    let borders = (0..lost.len()).filter(|&k| lost[k]).map(|k| first[k + 1]);
    let ends: Vec<usize> = [0].into_iter().chain(borders).chain([at.len()]).collect();
    ends.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// Returns the runs of a trace without missing samples, or of what is left of one that `is_cut`.
fn of_part(at: &[f64], deviation: &[f64], is_cut: bool) -> Vec<Run> {
    let n = deviation.len();
    if n < FEWEST || !(at[n - 1] > at[0]) {
        return Vec::new();
    }
    let long = wide::outliers(at, deviation);
    if long.is_empty() {
        return short(at, deviation, is_cut);
    }
    // long places would hide short ones, and medians next to them would not be the trace's
    let rest: Vec<usize> = (0..n).filter(|i| !long.iter().any(|run| (run.from..run.to).contains(i))).collect();
    let of_rest = |values: &[f64]| rest.iter().map(|&i| values[i]).collect::<Vec<f64>>();
    let short = if rest.len() < FEWEST { Vec::new() } else { short(&of_rest(at), &of_rest(deviation), is_cut) };
    let placed = short.into_iter().map(|run| Run { from: rest[run.from], to: rest[run.to - 1] + 1, ..run });
    let apart = placed.filter(|run| !long.iter().any(|long| run.from < long.to && long.from < run.to));
    let mut runs: Vec<Run> = apart.chain(long.iter().copied()).collect();
    runs.sort_by_key(|run| run.from);
    runs
}

/// Samples of a block.
fn block(count: usize) -> usize {
    (count / 8).clamp(5, LONGEST_BLOCK)
}

/// Median, and scale about it.
fn spread(values: &[f64]) -> [f64; 2] {
    let middle = median(&mut values.to_vec());
    [middle, MAD * median(&mut values.iter().map(|x| (x - middle).abs()).collect::<Vec<f64>>())]
}

/// Whether a place begins abruptly: its residuals, from its border on, grow from a quarter to three
/// quarters of their greatest within so many samples, and the trace next to it (`beside`, from the
/// border away) does not lead there.
fn is_abrupt(
    inside: impl Iterator<Item = [f64; 2]>,
    beside: impl Iterator<Item = [f64; 2]>,
    height: f64,
    within: usize,
) -> bool {
    let (mut quarter, mut most) = (None, None);
    for (k, [residual, deviation]) in inside.enumerate() {
        let share = residual / height;
        quarter = quarter.or((share >= 0.25).then_some(k));
        most = most.or((share >= 0.75).then_some((k, deviation)));
    }
    let Some((quarter, (most, deviation))) = quarter.zip(most) else { return false };
    most - quarter <= within
        && lead(beside, most).is_none_or(|[led, rms]| {
            let jump = (deviation - led) * height.signum();
            jump > LEAST_JUMP * height.abs() && jump > JUMP_OVER_RMS * rms
        })
}

/// Returns true if material protrudes at an end of a trace, of whose samples residuals and
/// deviations are given: it begins abruptly there, with a step.
fn protrudes_at_end(both: &[[f64; 2]], run: &Run) -> bool {
    let n = both.len();
    let (within, beside) = ((n / ABRUPT_AT_ENDS).max(2), (n / BESIDE).max(FEWEST_BESIDE));
    // from within the trace towards its end
    let towards: Vec<[f64; 2]> = match run.from {
        0 => both[..(run.to + beside).min(n)].iter().rev().copied().collect(),
        from => both[from.saturating_sub(beside)..].to_vec(),
    };
    let border = towards.len() - (run.to - run.from);
    let (lower, inside) = towards.split_at(border);
    run.height > 0.0
        && is_abrupt(inside.iter().copied(), lower.iter().rev().copied(), run.height, within)
        && steps(&towards, border, (n / STEP_AT_ENDS).max(1)) > LEAST_STEP * run.height
}

/// Whether a place within a trace, of whose samples residuals and deviations are given, begins or
/// ends abruptly.
fn jumps(both: &[[f64; 2]], run: &Run) -> bool {
    let n = both.len();
    let (within, beside) = ((n / ABRUPT_AT_ENDS).max(2), (n / BESIDE).max(FEWEST_BESIDE));
    let inside = || both[run.from..run.to].iter().copied();
    let (lower, upper) = (&both[run.from.saturating_sub(beside)..run.from], &both[run.to..(run.to + beside).min(n)]);
    is_abrupt(inside(), lower.iter().rev().copied(), run.height, within)
        || is_abrupt(inside().rev(), upper.iter().copied(), run.height, within)
}

/// By how much more a trace rises at most over so many samples within a place from its border on
/// than it did before.
fn steps(towards: &[[f64; 2]], border: usize, lag: usize) -> f64 {
    let at = |k: usize| towards[k][1];
    let each = (border.max(2 * lag)..towards.len()).map(|k| at(k) - 2.0 * at(k - lag) + at(k - 2 * lag));
    each.fold(f64::NEG_INFINITY, f64::max)
}

/// Extrapolates the least-squares parabola through the samples next to a border by so many samples,
/// and returns it with what it leaves; `None` of too few.
fn lead(beside: impl Iterator<Item = [f64; 2]>, beyond: usize) -> Option<[f64; 2]> {
    let deviation: Vec<f64> = beside.map(|[_, deviation]| deviation).collect();
    let n = deviation.len();
    if n < FEWEST_BESIDE {
        return None;
    }
    // counted from the border
    let place = |k: f64| (2.0 * k - (n - 1) as f64) / (n - 1) as f64;
    let u: Vec<f64> = (0..n).map(|k| place(k as f64)).collect();
    let curve = MeanCurves::of(&u, &deviation, &vec![1.0; n]);
    let left: f64 = u.iter().zip(&deviation).map(|(u, d)| (d - curve.parabola(*u)).powi(2)).sum();
    Some([curve.parabola(place(-1.0 - beyond as f64)), (left / (n - 3) as f64).sqrt()])
}

fn short(at: &[f64], deviation: &[f64], is_cut: bool) -> Vec<Run> {
    let n = deviation.len();
    let block = block(n);
    let residual = residuals(at, deviation, block);
    let everywhere = spread(&residual)[1].max(FINEST);
    // most traces have none that is far from 0, and are done here
    let limit = THRESHOLD * everywhere;
    let far: Vec<usize> = (0..n).filter(|&i| residual[i].abs() > 0.5 * limit).collect();
    let beyond = |i: usize, times: f64| {
        let (from, to) = (i.saturating_sub(block), (i + block + 1).min(n));
        let [middle, local] = spread(&residual[from..to]);
        (residual[i] - middle).abs() > times * local.max(everywhere)
    };
    let mut runs: Vec<Run> = Vec::new();
    for i in far.into_iter().asking(1000).filter(|&i| beyond(i, THRESHOLD)) {
        match runs.last_mut() {
            Some(run) if i < run.to => {}
            // one sample between may be a chance
            Some(run) if i <= run.to + 1 => run.to = i + 1,
            _ => runs.push(Run { from: i, to: i + 1, height: 0.0, burr: false }),
        }
    }
    for k in 0..runs.len() {
        let floor = if k > 0 { runs[k - 1].to } else { 0 };
        let ceiling = runs.get(k + 1).map_or(n, |next| next.from);
        let run = &mut runs[k];
        while run.from > floor && beyond(run.from - 1, SKIRT) {
            run.from -= 1;
        }
        while run.to < ceiling && beyond(run.to, SKIRT) {
            run.to += 1;
        }
        run.height =
            residual[run.from..run.to].iter().fold(0.0, |most: f64, r| if r.abs() > most.abs() { *r } else { most });
    }
    let most = block / 2 + 1;
    let both: Vec<[f64; 2]> = residual.iter().zip(deviation).map(|(r, d)| [*r, *d]).collect();
    runs.retain(|run| {
        let (ends, length) = (run.from == 0 || run.to == n, run.to - run.from);
        match (length <= 1, ends) {
            // a relief that falls off into a hole leaves a sample before it
            (true, _) => !(is_cut && ends) || run.height > 0.0,
            (false, true) => length <= most && protrudes_at_end(&both, run),
            // the knee of a relief deviates from the few medians of a part
            (false, false) => length <= most && (!is_cut || jumps(&both, run)),
        }
    });
    runs
}

/// About a curve that no short place moves.
fn residuals(at: &[f64], deviation: &[f64], block: usize) -> Vec<f64> {
    let n = deviation.len();
    let (low, high) = (at[0], at[n - 1]);
    let u: Vec<f64> = at.iter().map(|x| (2.0 * x - low - high) / (high - low)).collect();
    let parabola = MeanCurves::of(&u, deviation, &vec![1.0; n]);
    let mut left: Vec<f64> = u.iter().zip(deviation).map(|(&u, d)| d - parabola.parabola(u)).collect();
    // whole blocks, as even as they go
    let count = n / block;
    let ends = |k: usize| k * n / count;
    let knots: Vec<[f64; 2]> = (0..count)
        .map(|k| {
            let range = ends(k)..ends(k + 1);
            let middle = 0.5 * (range.start + range.end - 1) as f64;
            [middle, median(&mut left[range].to_vec())]
        })
        .collect();
    let mut k = 0;
    for (i, value) in left.iter_mut().enumerate().asking(5) {
        while k + 2 < count && i as f64 > knots[k + 1][0] {
            k += 1;
        }
        let [a, b] = [knots[k], knots[k + 1]];
        *value -= a[1] + (b[1] - a[1]) * (i as f64 - a[0]) / (b[0] - a[0]);
    }
    left
}
