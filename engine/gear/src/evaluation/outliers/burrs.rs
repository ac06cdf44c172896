//! Burrs: material that protrudes at an end of one trace, and not of most others of its flank.
//!
//! With four neighbouring blocks of samples, counted from an end inwards, the mean of the first is
//! compared with the line through the second and third, and with that through the third and fourth,
//! each difference less its median along the trace (curvature). The lesser of the two is the
//! excess, so that a dent in one block is no burr. A trace is suspected where its excess at an end
//! of the evaluation range is more than [`LEAST_RATIO`] times the usual one (quantile [`USUAL`] of
//! the amounts within the range, mean of the traces) and at least half of the other traces have
//! less than half of it: reliefs, fillets and breaks of the edge come on every tooth.

use super::{FINEST, Run, parts};
use crate::evaluation::samples::Sample;
use flankfit_numerics::{
    cancel,
    quantiles::{median, quantile},
};

/// A block has one in so many samples.
const BLOCKS: [usize; 4] = [96, 48, 24, 12];
const USUAL: f64 = 0.8;
const LEAST_RATIO: f64 = 4.5;
/// Share of an excess that at least half of the other traces do not reach.
const COMMON: f64 = 0.5;
/// Fewest traces of a flank that are compared.
pub(in crate::evaluation) const FEWEST_TRACES: usize = 3;
/// A burr ends where it is lower than this share of its height.
const FOOT: f64 = 0.02;

/// Height of an end over its neighbours, for one length of blocks.
#[derive(Clone, Copy)]
pub(in crate::evaluation) struct Excess {
    greatest: f64,
    usual: f64,
    burr: Burr,
}

/// How far both ends of a trace stand out, lower end first.
pub(in crate::evaluation) type Ends = [[Option<Excess>; BLOCKS.len()]; 2];

/// A burr at an end, by the blocks that show it.
#[derive(Clone, Copy)]
pub(in crate::evaluation) struct Burr {
    /// The first block begins so many samples from the end of the trace.
    from: usize,
    block: usize,
    /// Usual difference of a first block from the line through the third and fourth.
    curvature: f64,
}

/// The part of a trace at an end, from the end inwards.
struct Inwards {
    at: Vec<f64>,
    deviation: Vec<f64>,
    /// Samples outside of the evaluation range at this end, and at the other.
    beside: [usize; 2],
    /// Places of the part in the trace.
    part: [usize; 2],
}

impl Inwards {
    fn of(all: &[Sample], parts: &[[usize; 2]], upper: bool) -> Self {
        let part = if upper { parts[parts.len() - 1] } else { parts[0] };
        let mut samples = all[part[0]..part[1]].to_vec();
        if upper {
            samples.reverse();
        }
        let outside = |sample: &&Sample| !sample.within;
        Inwards {
            at: samples.iter().map(|s| s.at).collect(),
            deviation: samples.iter().map(|s| s.deviation).collect(),
            beside: [samples.iter().take_while(outside).count(), samples.iter().rev().take_while(outside).count()],
            part,
        }
    }

    /// `None` where the blocks would be empty or too long for the part.
    fn excess(&self, share: usize) -> Option<Excess> {
        let (n, [beside, beyond]) = (self.at.len(), self.beside);
        let block = n / share;
        let [low, high] = [beside + block, (n + 1).checked_sub(5 * block + beyond)?];
        if block == 0 || high < low + block {
            return None;
        }
        let (mean_at, mean_deviation) = (means(&self.at, block), means(&self.deviation, block));
        let difference = |k: usize, line: [usize; 2]| {
            let [x, y] = [&mean_at, &mean_deviation].map(|means| move |j: usize| means[k + j * block]);
            let [a, b] = line;
            // several samples may lie at one place
            let slope = if x(b) == x(a) { 0.0 } else { (y(b) - y(a)) / (x(b) - x(a)) };
            y(0) - y(a) - slope * (x(0) - x(a))
        };
        let [(near, slight), (far, curvature)] = [[1, 2], [2, 3]].map(|line| {
            let all: Vec<f64> = (0..=n - 4 * block).map(|k| difference(k, line)).collect();
            let usual = median(&mut all[low..high].to_vec());
            (all, usual)
        });
        let excess: Vec<f64> = near.iter().zip(far).map(|(near, far)| (near - slight).min(far - curvature)).collect();
        let mut amounts: Vec<f64> = excess[low..high].iter().map(|x| x.abs()).collect();
        amounts.sort_unstable_by(cancel::comparing(f64::total_cmp));
        let from = (0..=low).max_by(|a, b| excess[*a].total_cmp(&excess[*b]))?;
        Some(Excess { greatest: excess[from], usual: quantile(&amounts, USUAL), burr: Burr { from, block, curvature } })
    }

    /// The samples of a burr, from the end on.
    fn run(&self, burr: Burr) -> Run {
        let Burr { from, block, curvature } = burr;
        let third = from + 2 * block;
        let mean = |values: &[f64], k: usize| values[k..k + block].iter().sum::<f64>() / block as f64;
        let [x, y] = [&self.at, &self.deviation].map(|values| [mean(values, third), mean(values, third + block)]);
        let slope = if x[1] == x[0] { 0.0 } else { (y[1] - y[0]) / (x[1] - x[0]) };
        // the curvature is a parabola through both blocks of the line
        let product = |at: f64| (at - x[0]) * (at - x[1]);
        let first = product(mean(&self.at, from));
        let bend = if first == 0.0 { 0.0 } else { curvature / first };
        let height = |k: usize| self.deviation[k] - y[0] - slope * (self.at[k] - x[0]) - bend * product(self.at[k]);
        let highest = (0..third).max_by(|a, b| height(*a).total_cmp(&height(*b))).unwrap_or(0);
        let foot = (highest..third).find(|&k| height(k) < FOOT * height(highest)).unwrap_or(third);
        Run { from: 0, to: foot, height: height(highest), burr: true }
    }
}

/// Means of so many neighbours, by the first of them.
fn means(values: &[f64], count: usize) -> Vec<f64> {
    let middle = values[values.len() / 2];
    let mut sums = Vec::with_capacity(values.len() + 1);
    sums.push(0.0);
    let mut sum = 0.0;
    for value in values {
        sum += value - middle;
        sums.push(sum);
    }
    (count..sums.len()).map(|end| middle + (sums[end] - sums[end - count]) / count as f64).collect()
}

/// How far the ends of a trace stand out, of samples in ascending order.
pub(in crate::evaluation) fn ends(all: &[Sample]) -> Ends {
    cancel::checkpoint();
    let parts = parts(&all.iter().map(|s| s.at).collect::<Vec<f64>>());
    [false, true].map(|upper| {
        let inwards = Inwards::of(all, &parts, upper);
        BLOCKS.map(|share| inwards.excess(share))
    })
}

/// The burrs at both ends of each trace of a flank.
pub(in crate::evaluation) fn burrs(flank: &[Ends]) -> Vec<[Option<Burr>; 2]> {
    let mut found = vec![[None; 2]; flank.len()];
    for end in [0, 1] {
        for length in 0..BLOCKS.len() {
            let each: Vec<(usize, Excess)> =
                flank.iter().enumerate().filter_map(|(i, ends)| Some((i, ends[end][length]?))).collect();
            if each.len() < FEWEST_TRACES {
                continue;
            }
            let usual = each.iter().map(|(_, excess)| excess.usual).sum::<f64>() / each.len() as f64;
            let mut greatest: Vec<f64> = each.iter().map(|(_, excess)| excess.greatest).collect();
            greatest.sort_unstable_by(f64::total_cmp);
            // for traces above it the lower median of the others
            let others = greatest[(greatest.len() - 2) / 2];
            for (i, excess) in each {
                if excess.greatest > LEAST_RATIO * usual.max(FINEST) && others < COMMON * excess.greatest {
                    // the longest blocks tell best where it ends
                    found[i][end] = Some(excess.burr);
                }
            }
        }
    }
    found
}

/// The samples of the burrs of a trace, lower end first.
pub(in crate::evaluation) fn runs(all: &[Sample], burrs: [Option<Burr>; 2]) -> Vec<Run> {
    let mut runs = Vec::new();
    let parts = parts(&all.iter().map(|s| s.at).collect::<Vec<f64>>());
    for (burr, upper) in burrs.into_iter().zip([false, true]) {
        let Some(burr) = burr else { continue };
        let inwards = Inwards::of(all, &parts, upper);
        let (run, [first, end]) = (inwards.run(burr), inwards.part);
        runs.push(match upper {
            false => Run { from: first, to: first + run.to, ..run },
            true => Run { from: end - run.to, to: end, ..run },
        });
    }
    runs
}
