//! Effect of the measurement on a correction, to first order: how noise and errors of J come back
//! in the changes.
//!
//! In whitened rows (node k times √w_k) and columns of the fit's scaling, `J̃ = U Σ Vᵀ`, the free
//! settings are `θ = −A (d̃ + J̃_c Δ_c − t̃)` with the gain `A = V F Σ⁻¹ Uᵀ`, F the filter factors.
//! Hence
//!
//! * noise σ of the deviations leaves the variance `σ² Σ_k A_ik²` in θ_i;
//! * the predicted change `c = JΔ` follows the noise of its own measurement with `∂c̃/∂d̃ = −H`, `H
//!   = U F Uᵀ`, whose diagonal is the **leverage** of each node;
//! * where the machine responds with G = J + E, what is wanted differs from θ by `A E Δ + K Eᵀ r`,
//!   `K = V F Λ⁻¹ Vᵀ`, r the deviations that remain (first order of `(J + E)⁺ y` in E; along damped
//!   directions, where that inverse is not wanted, K has `F² Λ⁻¹`). With `E_kj = η J_kj g_kj`
//!   this gives the variances of [`Gain::errors`].
//!
//! F is taken for what it is; that λ* follows the deviations a little is left out. Where F is not a
//! filter along these directions (Tikhonov; standardised columns with a regularisation) the gain is
//! that of plain least squares, which is larger.

use nalgebra::DMatrix;

use super::problem::{Correction, ResponseErrors};
use flankfit_estimation::{FitResult, result::RegularizationKind, spec::Scaling};
use flankfit_numerics::{cancel::Asking, qr_with_rhs, svd};

/// The map from whitened deviations to the free settings.
pub(super) struct Gain<'a> {
    correction: &'a Correction,
    free: &'a [usize],
    /// Length that each free column was divided by.
    scale: Vec<f64>,
    /// V, columns in ascending order of the eigenvalues.
    v: DMatrix<f64>,
    /// fᵢ/λᵢ, 0 where nothing comes through.
    inverse: Vec<f64>,
    /// fᵢ.
    factor: Vec<f64>,
}

/// Standard deviations of the free settings, in their units.
pub(super) struct Errors {
    /// For σ = 1.
    pub noise: Vec<f64>,
    /// Standard errors due to errors of J of the size η.
    pub response: Vec<f64>,
}

impl<'a> Gain<'a> {
    /// The gain of `fit`, which fits the settings `free`; `None` where the singular values do not
    /// converge.
    pub(crate) fn new(correction: &'a Correction, free: &'a [usize], fit: &FitResult) -> Option<Self> {
        let (rows, n) = (correction.counted().len(), free.len());
        let filtered = !matches!(fit.regularization.kind, RegularizationKind::None);
        let scaling = correction.spec().scaling;
        let mut columns = DMatrix::zeros(rows, n);
        for (i, &k) in correction.counted().iter().enumerate() {
            let root = correction.weight(k).sqrt();
            for (j, &setting) in free.iter().enumerate() {
                columns[(i, j)] = root * correction.row(k)[setting];
            }
        }
        let scale: Vec<f64> = match scaling {
            Scaling::None => vec![1.0; n],
            _ => columns.column_iter().map(|column| column.norm()).collect(),
        };
        for (mut column, scale) in columns.column_iter_mut().zip(&scale) {
            column /= *scale;
        }
        let found = svd(qr_with_rhs(columns, nalgebra::DVector::zeros(rows)).r)?;
        let plain = scaling == Scaling::Standardized || fit.regularization.kind == RegularizationKind::Tikhonov;
        let factor = |i: usize| match fit.regularization.shrinkage_factor {
            Some(factor) => factor,
            None if filtered && !plain => fit.regularization.filter_factors.get(i).copied().unwrap_or(1.0),
            None => 1.0,
        };
        // directions that the fit does not tell from 0 let nothing through
        let lost = n - fit.spectrum.rank.min(n);
        let through = |i: usize| if i < lost && !plain { 0.0 } else { factor(i) };
        let factor: Vec<f64> = (0..n).map(through).collect();
        let inverse = factor
            .iter()
            .zip(&found.sigma)
            .map(|(f, sigma)| if *f == 0.0 || !(*sigma > 0.0) { 0.0 } else { f / (sigma * sigma) })
            .collect();
        Some(Gain { correction, free, scale, v: found.v, inverse, factor })
    }

    /// √w J of a node in the scaled columns.
    fn row(&self, k: usize) -> Vec<f64> {
        let (root, row) = (self.correction.weight(k).sqrt(), self.correction.row(k));
        self.free.iter().zip(&self.scale).map(|(&j, scale)| root * row[j] / scale).collect()
    }

    /// Vᵀ x, each entry times fᵢ/λᵢ.
    fn along(&self, x: &[f64]) -> Vec<f64> {
        let n = self.inverse.len();
        (0..n).map(|i| self.inverse[i] * (0..n).map(|j| self.v[(j, i)] * x[j]).sum::<f64>()).collect()
    }

    /// V a.
    fn back(&self, a: &[f64]) -> Vec<f64> {
        let n = a.len();
        (0..n).map(|j| (0..n).map(|i| self.v[(j, i)] * a[i]).sum()).collect()
    }

    /// h of each node, 0 where it takes no part.
    pub(crate) fn leverage(&self) -> Vec<f64> {
        let mut leverage = vec![0.0; self.correction.spec().deviation.len()];
        for &k in self.correction.counted().iter().asking(2 * self.free.len() * self.free.len()) {
            let row = self.row(k);
            let h: f64 = self.back(&self.along(&row)).iter().zip(&row).map(|(a, x)| a * x).sum();
            leverage[k] = h.clamp(0.0, 1.0);
        }
        leverage
    }

    /// How far each free setting follows a change of the flank that is all its own: the diagonal of
    /// `V F Vᵀ`, which sums to that of H.
    pub(crate) fn following(&self) -> Vec<f64> {
        let n = self.factor.len();
        (0..n).map(|j| (0..n).map(|i| self.v[(j, i)] * self.v[(j, i)] * self.factor[i]).sum()).collect()
    }

    /// Σ (1 − h) w u²: what errors of J of their own at each entry add to the residual sum of
    /// squares.
    pub(crate) fn response_rss(&self, change: &[f64], leverage: &[f64]) -> f64 {
        let asked = self.correction.spec();
        if asked.response_errors == ResponseErrors::PerSetting {
            return 0.0;
        }
        let eta = asked.response_uncertainty;
        let of = |&k: &usize| {
            let u: f64 =
                self.correction.given_row(k).iter().zip(change).map(|(j, c)| (eta * j * c) * (eta * j * c)).sum();
            (1.0 - leverage[k]) * self.correction.weight(k) * u
        };
        self.correction.counted().iter().map(of).sum()
    }

    /// Standard errors of the free settings, in their units, by the scatter of teeth.
    pub(crate) fn scatter(&self) -> Vec<f64> {
        let mut variance = vec![0.0; self.free.len()];
        for column in &self.correction.spec().scatter.columns {
            let mut along = vec![0.0; self.free.len()];
            for &k in self.correction.counted().iter().asking(self.free.len()) {
                let root = self.correction.weight(k).sqrt();
                along.iter_mut().zip(self.row(k)).for_each(|(sum, x)| *sum += root * column[k] * x);
            }
            let moved = self.back(&self.along(&along));
            variance.iter_mut().zip(moved).for_each(|(sum, x)| *sum += x * x);
        }
        variance.iter().zip(&self.scale).map(|(variance, scale)| variance.sqrt() / scale).collect()
    }

    /// Errors of the free settings for the changes `change` of all; `misfit` is the share of the
    /// remaining deviations that is no noise.
    pub(crate) fn errors(&self, change: &[f64], misfit: f64) -> Errors {
        let asked = self.correction.spec();
        let (n, all, eta) = (self.free.len(), change.len(), asked.response_uncertainty);
        let mut place = vec![None; all];
        self.free.iter().enumerate().for_each(|(i, &j)| place[j] = Some(i));
        // K
        let entry = |i: usize, l: usize| -> f64 {
            (0..n).map(|d| self.v[(i, d)] * self.factor[d] * self.inverse[d] * self.v[(l, d)]).sum()
        };
        let inverse: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|l| entry(i, l)).collect()).collect();
        let (mut noise, mut response) = (vec![0.0; n], vec![0.0; n]);
        let mut whole = vec![0.0; n * all];
        for &k in self.correction.counted().iter().asking(n * (n + all)) {
            let (w, jacobian, row) = (self.correction.weight(k), self.correction.row(k), self.row(k));
            let given = self.correction.given_row(k);
            let root = w.sqrt();
            let gain = self.back(&self.along(&row));
            let left = root * misfit.sqrt() * self.correction.left_at(k, change);
            for i in 0..n {
                noise[i] += gain[i] * gain[i];
                for j in 0..all {
                    match asked.response_errors {
                        ResponseErrors::Independent => {
                            let x = root * given[j];
                            let turned = place[j].map_or(0.0, |l| inverse[i][l] / self.scale[l] * left);
                            response[i] += (eta * x * (gain[i] * change[j] + turned)).powi(2);
                        }
                        ResponseErrors::PerSetting => whole[i * all + j] += gain[i] * root * jacobian[j],
                    }
                }
            }
        }
        if asked.response_errors == ResponseErrors::PerSetting {
            for (i, sum) in response.iter_mut().enumerate() {
                *sum = (0..all).map(|j| (eta * whole[i * all + j] * change[j]).powi(2)).sum();
            }
        }
        let deviation = |sums: Vec<f64>| sums.iter().zip(&self.scale).map(|(sum, scale)| sum.sqrt() / scale).collect();
        Errors { noise: deviation(noise), response: deviation(response) }
    }
}
