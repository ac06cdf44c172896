//! Mean curves of a trace with gaps, and how well they are determined.
//!
//! The standard fits its line to the whole evaluation range. A line through the samples on both
//! sides of a hole is another one: on a crowned flank it is off by as much as the parabola bends
//! over what is missing. So a gap is filled with what the flank most likely is there, and the
//! curves are fitted to the whole range.
//!
//! Of the flank it is supposed that it is a parabola and a form that varies about as much
//! everywhere, with a covariance `s² m(d/ℓ)` of places at a distance d, m being Matérn's of order
//! 5/2 (forms that are twice differentiable). Means of samples over short blocks, with the noise of
//! the samples, then tell the most likely form in the gap and its standard error in closed form
//! (best linear unbiased prediction: exact for every parabola). Size s and length ℓ are not known.
//! The likelihood of what the parabola leaves (restricted: of what no parabola moves) says which
//! are more probable than others, and the answer is their weighted mean, with what they differ by
//! in its error. A parabola with noise is filled by a parabola with the error of the noise; where
//! waves are left, the error is about what waves may hide in the gap.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix3, OMatrix, U3, Vector3};

use super::{
    mean_curve::{FIGURES, MeanCurves},
    spacing::Spacing,
};
use flankfit_numerics::cancel::{self, Asking};

/// Blocks that a whole range has, and cells of a gap per range.
const BLOCKS: f64 = 48.0;
/// Fewest blocks that tell more than a parabola.
const FEWEST_BLOCKS: usize = 8;
/// Lengths of forms that are tried; the range is 2 long.
const LENGTHS: [f64; 5] = [0.08, 0.16, 0.32, 0.64, 1.28];
/// Sizes that are tried, over the root mean square of what the parabola leaves in the blocks. A
/// long form is mostly taken up by the parabola, so that little of it is left.
const SIZES: [f64; 8] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
/// No noise is smaller than this share of what the parabola leaves: matrices stay well conditioned.
const LEAST_NOISE: f64 = 1e-3;

/// Mean curves over the whole range.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GapEstimate {
    pub curves: MeanCurves,
    /// Standard errors of [`MeanCurves::figures`]; `None` where the noise is not known.
    pub errors: Option<[f64; FIGURES]>,
}

/// Returns the curves of samples at three ascending places at least, with the standard deviation of
/// their noise.
pub(crate) fn mean_curves(u: &[f64], deviation: &[f64], spacing: &Spacing, noise: Option<f64>) -> GapEstimate {
    let near = MeanCurves::of(u, deviation, &spacing.weight);
    if spacing.gaps.is_empty() {
        let errors = noise.map(|noise| squares(&near, u, &spacing.weight).map(|sum| noise * sum.sqrt()));
        return GapEstimate { curves: near, errors };
    }
    let cells = Cells::of(&spacing.gaps);
    let parabola: Vec<f64> = cells.at.iter().map(|u| near.parabola(*u)).collect();
    let (places, weights) = ([u, &cells.at].concat(), [&spacing.weight[..], &cells.length].concat());
    let filled = |form: &[f64]| {
        let fill: Vec<f64> = parabola.iter().zip(form).map(|(curve, form)| curve + form).collect();
        MeanCurves::of(&places, &[deviation, &fill].concat(), &weights)
    };
    let still = filled(&vec![0.0; cells.at.len()]);
    let Some(noise) = noise else { return GapEstimate { curves: still, errors: None } };
    let blocks = Blocks::of(u, deviation, spacing, &near);
    let factors = |u: &[f64], weight: &[f64]| -> Vec<[f64; FIGURES]> {
        u.iter().zip(weight).map(|(u, weight)| still.factors(*u, *weight)).collect()
    };
    let asked = GapModel {
        blocks: &blocks,
        cells: &cells,
        of_cells: DMatrix::from_row_iterator(
            cells.at.len(),
            FIGURES,
            factors(&cells.at, &cells.length).into_iter().flatten(),
        ),
        of_blocks: blocks.sums(&factors(u, &spacing.weight)),
        noise: noise.max(LEAST_NOISE * blocks.rms),
    };
    let own = squares(&still, u, &spacing.weight).map(|sum| sum * noise * noise);
    match asked.predicted(own) {
        Some((form, errors)) => GapEstimate { curves: filled(&form), errors: Some(errors) },
        None => GapEstimate { curves: still, errors: None },
    }
}

/// Sums of the squared factors.
fn squares(curves: &MeanCurves, u: &[f64], weight: &[f64]) -> [f64; FIGURES] {
    let mut sums = [0.0; FIGURES];
    for (u, weight) in u.iter().zip(weight).asking(5) {
        for (sum, factor) in sums.iter_mut().zip(curves.factors(*u, *weight)) {
            *sum += factor * factor;
        }
    }
    sums
}

/// Equal cells of the gaps: their middles and lengths.
struct Cells {
    at: Vec<f64>,
    length: Vec<f64>,
}

impl Cells {
    fn of(gaps: &[[f64; 2]]) -> Self {
        let mut cells = Cells { at: Vec::new(), length: Vec::new() };
        for &[from, to] in gaps {
            let count = (0.5 * BLOCKS * (to - from)).ceil().max(1.0);
            let length = (to - from) / count;
            for k in 0..count as usize {
                cells.at.push(from + (k as f64 + 0.5) * length);
                cells.length.push(length);
            }
        }
        cells
    }
}

/// Means of what the parabola leaves over neighbouring samples.
struct Blocks {
    /// First sample of each, and its end.
    ranges: Vec<[usize; 2]>,
    at: Vec<f64>,
    left: DVector<f64>,
    rms: f64,
}

impl Blocks {
    fn of(u: &[f64], deviation: &[f64], spacing: &Spacing, parabola: &MeanCurves) -> Self {
        let cell = |i: usize| (0.5 * BLOCKS * (u[i] + 1.0)).floor();
        let mut ranges: Vec<[usize; 2]> = Vec::new();
        for i in (0..u.len()).asking(5) {
            match ranges.last_mut() {
                Some(range) if cell(range[0]) == cell(i) && !spacing.crosses(u[i - 1], u[i]) => range[1] = i + 1,
                _ => ranges.push([i, i + 1]),
            }
        }
        let mean = |[from, to]: [usize; 2], of: &dyn Fn(usize) -> f64| {
            (from..to).asking(5).map(of).sum::<f64>() / (to - from) as f64
        };
        let at = ranges.iter().map(|range| mean(*range, &|i| u[i])).collect();
        let left: Vec<f64> =
            ranges.iter().map(|range| mean(*range, &|i| deviation[i] - parabola.parabola(u[i]))).collect();
        let left = DVector::from_vec(left);
        let rms = left.norm() / (ranges.len().max(1) as f64).sqrt();
        Blocks { ranges, at, left, rms }
    }

    /// Samples of each.
    fn counts(&self) -> DVector<f64> {
        DVector::from_iterator(self.ranges.len(), self.ranges.iter().map(|[from, to]| (to - from) as f64))
    }

    fn sums(&self, factors: &[[f64; FIGURES]]) -> DMatrix<f64> {
        DMatrix::from_fn(self.ranges.len(), FIGURES, |b, k| {
            let [from, to] = self.ranges[b];
            factors[from..to].iter().map(|f| f[k]).sum()
        })
    }
}

/// Basis of the prediction of the form in the gaps.
struct GapModel<'a> {
    blocks: &'a Blocks,
    cells: &'a Cells,
    /// Factors of the cells, and of the samples of each block together, in the figures.
    of_cells: DMatrix<f64>,
    of_blocks: DMatrix<f64>,
    /// Standard deviation of the noise of a sample.
    noise: f64,
}

/// Form in the gaps by one size and length.
struct Prediction {
    log_likelihood: f64,
    form: DVector<f64>,
    /// Contribution of the form in the gaps to the variance of the figures, together with what it
    /// shares with the noise.
    variance: [f64; FIGURES],
}

/// 1, u, u² at places.
fn powers(at: &[f64]) -> OMatrix<f64, Dyn, U3> {
    OMatrix::<f64, Dyn, U3>::from_fn(at.len(), |i, k| at[i].powi(k as i32))
}

/// Matérn's covariance of order 5/2.
fn covariance(a: &[f64], b: &[f64], length: f64) -> DMatrix<f64> {
    DMatrix::from_fn(a.len(), b.len(), |i, j| {
        let d = 5f64.sqrt() * (a[i] - b[j]).abs() / length;
        (1.0 + d + d * d / 3.0) * (-d).exp()
    })
}

impl GapModel<'_> {
    /// The most likely form in the cells, and the standard errors of the figures whose samples'
    /// noise alone has the variances `own`; `None` where blocks are too few.
    fn predicted(&self, own: [f64; FIGURES]) -> Option<(Vec<f64>, [f64; FIGURES])> {
        if self.blocks.at.len() < FEWEST_BLOCKS {
            return None;
        }
        if !(self.noise > 0.0) {
            return Some((vec![0.0; self.cells.at.len()], own.map(f64::sqrt)));
        }
        let mut each = vec![(0.5, self.by(None)?)];
        for length in LENGTHS {
            cancel::checkpoint();
            let near = covariance(&self.blocks.at, &self.blocks.at, length);
            let across = covariance(&self.blocks.at, &self.cells.at, length);
            let within = covariance(&self.cells.at, &self.cells.at, length);
            for size in SIZES {
                let variance = (size * self.blocks.rms).powi(2);
                let form = [&near, &across, &within].map(|m| m * variance);
                // the last digits of a form a million times the noise make no matrix positive
                let Some(found) = self.by(Some(&form)) else { continue };
                each.push((0.5 / (LENGTHS.len() * SIZES.len()) as f64, found));
            }
        }
        let most = each.iter().map(|(_, found)| found.log_likelihood).fold(f64::NEG_INFINITY, f64::max);
        let shares: Vec<f64> = each.iter().map(|(prior, found)| prior * (found.log_likelihood - most).exp()).collect();
        let total: f64 = shares.iter().sum();
        let weighted = || shares.iter().map(|share| share / total).zip(&each).map(|(share, (_, found))| (share, found));
        let mut form = DVector::zeros(self.cells.at.len());
        for (share, found) in weighted() {
            form += &found.form * share;
        }
        let errors = std::array::from_fn(|k| {
            let factors = self.of_cells.column(k);
            let variance = weighted().map(|(share, found)| {
                let apart = factors.dot(&(&found.form - &form));
                share * (found.variance[k] + apart * apart)
            });
            (own[k] + variance.sum::<f64>()).max(0.0).sqrt()
        });
        Some((form.as_slice().to_vec(), errors))
    }

    /// By covariances of the form among blocks, of blocks and cells, among cells; `None`: there is
    /// no form.
    fn by(&self, form: Option<&[DMatrix<f64>; 3]>) -> Option<Prediction> {
        let noise = self.blocks.counts().map(|count| self.noise * self.noise / count);
        let mut variance = DMatrix::from_diagonal(&noise);
        if let Some([near, ..]) = form {
            variance += near;
        }
        let (of_blocks, of_cells) = (powers(&self.blocks.at), powers(&self.cells.at));
        let whole = Cholesky::new(variance)?;
        let solved = whole.solve(&of_blocks);
        let square: Matrix3<f64> = of_blocks.tr_mul(&solved);
        let parabola = Cholesky::new(square)?;
        let beta: Vector3<f64> = parabola.solve(&solved.tr_mul(&self.blocks.left));
        let beyond = &self.blocks.left - &of_blocks * beta;
        let dual = whole.solve(&beyond);
        let log = |diagonal: f64| diagonal.ln();
        let log_likelihood = -whole.l_dirty().diagonal().map(log).sum()
            - parabola.l_dirty().diagonal().map(log).sum()
            - 0.5 * beyond.dot(&dual);
        let mut predicted = &of_cells * beta;
        let factors = &self.of_cells;
        let mut open = of_cells.tr_mul(factors);
        let mut of_form = DMatrix::zeros(self.blocks.at.len(), FIGURES);
        let mut hidden = DMatrix::zeros(FIGURES, FIGURES);
        if let Some([_, across, within]) = form {
            predicted += across.tr_mul(&dual);
            let shared = across * factors;
            of_form = whole.solve(&shared);
            hidden = factors.tr_mul(&(within * factors)) - shared.tr_mul(&of_form);
            open -= solved.tr_mul(&shared);
        }
        let by_parabola = parabola.solve(&open);
        hidden += open.tr_mul(&by_parabola);
        // what each block adds to the figures through the gaps
        let through = of_form + &solved * by_parabola;
        let shared = |k: usize| -> f64 {
            (0..self.blocks.at.len()).map(|b| self.of_blocks[(b, k)] * noise[b] * through[(b, k)]).sum()
        };
        Some(Prediction {
            log_likelihood,
            form: predicted,
            variance: std::array::from_fn(|k| hidden[(k, k)] + 2.0 * shared(k)),
        })
    }
}
