//! The second-order surface through traces, each of which may have a zero of its own.
//!
//! A measuring machine zeroes each profile and each helix by itself, so of the level of a trace
//! nothing is known: `δ = a_t + c_u u + c_v v + c_uu u² + c_uv uv + c_vv v²` with a nuisance
//! parameter a_t for every trace t. It is taken out by centring columns and deviations trace by
//! trace (Frisch, Waugh and Lovell), which gives the same estimates and errors as a column for each
//! a_t. Samples count by the length that they stand for.
//!
//! *Determination.* All columns run over [-1, 1], so a direction of the coefficients whose singular
//! value is below 1/30 of the greatest (Belsley) is one that the samples do not determine. The term
//! of highest order with the greatest share in such directions is left out, until none is left. A
//! slope whose twist is left out is that in the section of its trace.

use nalgebra::{DMatrix, DVector};

use super::super::noise::EstimatedVariance;
use flankfit_estimation::spec::DEFAULT_CONDITION_LIMIT;
use flankfit_numerics::{
    cancel::{self, Asking},
    qr_with_rhs, svd,
};

/// A sample of a trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    pub u: f64,
    pub v: f64,
    /// µm.
    pub deviation: f64,
    /// The length that it represents.
    pub weight: f64,
}

/// Terms of second order: 1, u, v, u², uv, v².
pub(crate) const TERMS: usize = 6;
const ORDER: [usize; TERMS] = [0, 1, 1, 2, 2, 2];
/// Share in the undetermined directions from which on a term belongs to them.
const SHARE: f64 = 0.1;

/// The surface, as far as the traces tell it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Through {
    /// Coefficients of 1, u, v, u², uv and v²; `None` where the traces do not determine it. Of 1
    /// only where all traces share one zero.
    pub coefficients: [Option<f64>; TERMS],
    /// a_t of each trace; the constant of the surface where all share one zero.
    pub zeros: Vec<f64>,
    /// Σ weight · residual².
    pub rss: f64,
    kept: Vec<usize>,
    /// The inverse of the kept columns' triangular factor.
    inverse: DMatrix<f64>,
    share_zero: bool,
}

fn row(sample: &Sample) -> [f64; TERMS] {
    let Sample { u, v, .. } = *sample;
    [1.0, u, v, u * u, u * v, v * v]
}

/// Means of the columns and of the deviation over a trace with a zero of its own, else zeros.
fn means(trace: &[Sample], share_zero: bool) -> ([f64; TERMS], f64) {
    let (mut columns, mut deviation, mut whole) = ([0.0; TERMS], 0.0, 0.0);
    if share_zero {
        return (columns, deviation);
    }
    for sample in trace {
        columns.iter_mut().zip(row(sample)).for_each(|(sum, x)| *sum += sample.weight * x);
        deviation += sample.weight * sample.deviation;
        whole += sample.weight;
    }
    if whole > 0.0 {
        columns.iter_mut().for_each(|sum| *sum /= whole);
        deviation /= whole;
    }
    (columns, deviation)
}

/// Fits the surface; `None` where the traces tell none of its terms.
pub(crate) fn through(traces: &[Vec<Sample>], share_zero: bool) -> Option<Through> {
    let (mut r, mut qty, mut rss) = (DMatrix::zeros(0, TERMS), DVector::zeros(0), 0.0);
    for trace in traces {
        cancel::checkpoint();
        let (middle, level) = means(trace, share_zero);
        let above = r.nrows();
        let mut columns = DMatrix::zeros(above + trace.len(), TERMS);
        let mut heights = DVector::zeros(above + trace.len());
        columns.rows_mut(0, above).copy_from(&r);
        heights.rows_mut(0, above).copy_from(&qty);
        for (i, sample) in trace.iter().enumerate().asking(20) {
            let root = sample.weight.sqrt();
            for (j, x) in row(sample).into_iter().enumerate() {
                columns[(above + i, j)] = root * (x - middle[j]);
            }
            heights[above + i] = root * (sample.deviation - level);
        }
        let folded = qr_with_rhs(columns, heights);
        rss += folded.rss;
        (r, qty) = (folded.r, folded.qty);
    }
    if r.nrows() < TERMS {
        return None;
    }
    let mut kept: Vec<usize> = (usize::from(!share_zero)..TERMS).collect();
    let (factor, heights) = loop {
        if kept.is_empty() {
            return None;
        }
        let found = qr_with_rhs(r.select_columns(&kept), qty.clone());
        let spectrum = svd(found.r.clone())?;
        let least = spectrum.sigma.last()? / DEFAULT_CONDITION_LIMIT.sqrt();
        let lost: Vec<usize> = (0..kept.len()).filter(|&i| !(spectrum.sigma[i] > least)).collect();
        if lost.is_empty() {
            rss += found.rss;
            break (found.r, found.qty);
        }
        let share = |j: usize| lost.iter().map(|&i| spectrum.v[(j, i)].powi(2)).sum::<f64>();
        let out = (0..kept.len())
            .filter(|&j| share(j) >= SHARE)
            .max_by(|&a, &b| ORDER[kept[a]].cmp(&ORDER[kept[b]]).then(share(a).total_cmp(&share(b))))?;
        kept.remove(out);
    };
    let inverse = factor.solve_upper_triangular(&DMatrix::identity(kept.len(), kept.len()))?;
    let found = &inverse * heights;
    let mut values = [0.0; TERMS];
    kept.iter().zip(found.iter()).for_each(|(&term, value)| values[term] = *value);
    let zeros = traces
        .iter()
        .map(|trace| {
            let (middle, level) = means(trace, share_zero);
            match share_zero {
                true => values[0],
                false => level - middle.iter().zip(&values).map(|(x, c)| x * c).sum::<f64>(),
            }
        })
        .collect();
    let mut coefficients = [None; TERMS];
    kept.iter().for_each(|&term| coefficients[term] = Some(values[term]));
    if kept.len() < TERMS {
        // with a term less it is the level of other places than the middle
        coefficients[0] = None;
    }
    Some(Through { coefficients, zeros, rss: rss.max(0.0), kept, inverse, share_zero })
}

impl Through {
    /// Residual of a sample of trace `t` about the surface.
    pub(crate) fn left(&self, t: usize, sample: &Sample) -> f64 {
        let x = row(sample);
        let shape: f64 = (1..TERMS).map(|j| self.coefficients[j].unwrap_or(0.0) * x[j]).sum();
        sample.deviation - self.zeros[t] - shape
    }

    /// Variances of the coefficients where the samples of trace t have the variance `of(t)` and are
    /// independent.
    pub(crate) fn variances(
        &self,
        traces: &[Vec<Sample>],
        of: impl Fn(usize) -> EstimatedVariance,
    ) -> [Option<EstimatedVariance>; TERMS] {
        let n = self.kept.len();
        let mut parts: [Vec<EstimatedVariance>; TERMS] = Default::default();
        for (t, trace) in traces.iter().enumerate() {
            let (middle, _) = means(trace, self.share_zero);
            let noise = of(t);
            let mut sums = [0.0; TERMS];
            for sample in trace.iter().asking(2 * n * n) {
                let (x, mut turned) = (row(sample), [0.0; TERMS]);
                for i in 0..n {
                    let weighted = |j: usize| sample.weight * (x[self.kept[j]] - middle[self.kept[j]]);
                    turned[i] = (0..=i).map(|j| self.inverse[(j, i)] * weighted(j)).sum();
                }
                for i in 0..n {
                    let influence: f64 = (i..n).map(|j| self.inverse[(i, j)] * turned[j]).sum();
                    sums[self.kept[i]] += noise.value * influence * influence;
                }
            }
            for (parts, value) in parts.iter_mut().zip(sums).filter(|(_, value)| *value > 0.0) {
                parts.push(EstimatedVariance { value, ..noise });
            }
        }
        let mut variances = [None; TERMS];
        for &term in &self.kept {
            variances[term] = Some(EstimatedVariance::sum(parts[term].iter().copied()));
        }
        variances
    }
}
