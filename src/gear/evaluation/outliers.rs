//! Samples that stand out of their neighbours: dust, chips, a probe that lifted off.
//!
//! A smooth curve through medians (the mean parabola taken away, then medians of blocks with straight lines between
//! them) leaves residuals. A sample is suspected where its residual is more than [`THRESHOLD`] times the scale (1.4826
//! × median absolute deviation) of the whole trace *and* of its own neighbourhood, about the neighbourhood's median
//! (Hampel's rule with a window), and where the trace comes back behind it: what goes on to the end of the trace is a
//! relief or a break of the edge. The standard counts such samples, and so does the evaluation unless they are asked to
//! be left out; but it says so.

use crate::numerics::{cancel::Asking, quantiles::median};

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
/// Normal standard deviation over median absolute deviation.
const MAD: f64 = 1.482_602_218_505_602;

/// Neighbouring samples that stand out, by their places in the ascending trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    pub from: usize,
    /// The first behind it.
    pub to: usize,
    /// Greatest residual, with its sign, in the unit of the deviations.
    pub height: f64,
}

/// The suspected places of a trace with samples at ascending `at`; all defined.
pub fn outliers(at: &[f64], deviation: &[f64]) -> Vec<Run> {
    let n = deviation.len();
    let spread = |values: &[f64]| -> [f64; 2] {
        let middle = median(&mut values.to_vec());
        [middle, MAD * median(&mut values.iter().map(|x| (x - middle).abs()).collect::<Vec<f64>>())]
    };
    if n < FEWEST || !(at[n - 1] > at[0]) {
        return Vec::new();
    }
    let block = (n / 8).clamp(5, LONGEST_BLOCK);
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
            _ => runs.push(Run { from: i, to: i + 1, height: 0.0 }),
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
    runs.retain(|run| {
        let ends = run.from == 0 || run.to == n;
        run.to - run.from <= if ends { 1 } else { most }
    });
    runs
}

/// About a curve that no short place moves.
fn residuals(at: &[f64], deviation: &[f64], block: usize) -> Vec<f64> {
    let n = deviation.len();
    let (low, high) = (at[0], at[n - 1]);
    let u: Vec<f64> = at.iter().map(|x| (2.0 * x - low - high) / (high - low)).collect();
    let parabola = super::mean_curve::MeanCurves::of(&u, deviation, &vec![1.0; n]);
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
