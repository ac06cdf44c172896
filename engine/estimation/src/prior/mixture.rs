//! Mean and covariance over the sizes of the moves.

use nalgebra::{DMatrix, DVector};

use super::{
    chain::{Branch, weights},
    information::Information,
};
use flankfit_numerics::qr_with_rhs;

/// Shares of the whole below which a branch is left out.
const NOTHING: f64 = 1e-18;

/// The posterior in units of σ, along the columns of now, from least squares.
pub(crate) struct Mixture {
    /// Its mean.
    pub mean: DVector<f64>,
    /// C with covariance `CᵀC`, upper triangular.
    pub root: DMatrix<f64>,
    /// Share of the present heights in the mean.
    pub gain: DMatrix<f64>,
    /// The mean of the prior.
    pub prior_mean: DVector<f64>,
    /// Rows C with the prior's covariance `CᵀC`.
    pub prior_root: DMatrix<f64>,
}

impl Mixture {
    /// Mixture of branches with the logarithms of their weights.
    pub(super) fn new<'a>(branches: impl Iterator<Item = (&'a Branch, f64)>) -> Self {
        let (branches, logarithms): (Vec<&Branch>, Vec<f64>) = branches.unzip();
        let weights = weights(logarithms.into_iter());
        let (mean, root) = moments(branches.iter().map(|branch| &branch.posterior), &weights);
        let (prior_mean, prior_root) = moments(branches.iter().map(|branch| &branch.prior), &weights);
        let n = mean.len();
        let mut gain = DMatrix::zeros(n, n);
        for (branch, &weight) in branches.iter().zip(&weights).filter(|(_, weight)| **weight > NOTHING) {
            let inverse = branch.posterior.inverse();
            add_square(&mut gain, &inverse, weight);
        }
        Mixture { mean, root, gain, prior_mean, prior_root }
    }

    /// True if doubles hold it.
    pub(super) fn is_finite(&self) -> bool {
        let all = |mut values: std::slice::Iter<f64>| values.all(|x| x.is_finite());
        let vectors = [self.mean.as_slice(), self.prior_mean.as_slice()];
        let matrices = [&self.root, &self.gain, &self.prior_root].map(DMatrix::as_slice);
        !self.mean.is_empty() && vectors.into_iter().chain(matrices).all(|values| all(values.iter()))
    }
}

/// Mean and the triangular root of the covariance of a mixture: within its parts, and between.
fn moments<'a>(parts: impl Iterator<Item = &'a Information>, weights: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
    let parts: Vec<(&Information, f64, DVector<f64>)> = parts
        .zip(weights)
        .filter(|(_, weight)| **weight > NOTHING)
        .map(|(part, &weight)| (part, weight, part.mean()))
        .collect();
    let n = parts.first().map_or(0, |(part, ..)| part.size());
    let mean = parts.iter().fold(DVector::zeros(n), |sum, (_, weight, mean)| sum + mean * *weight);
    let mut rows = DMatrix::zeros(parts.len() * (n + 1), n);
    for (k, (part, weight, own)) in parts.iter().enumerate() {
        let (at, root) = (k * (n + 1), weight.sqrt());
        rows.view_mut((at, 0), (n, n)).copy_from(&(part.inverse().transpose() * root));
        rows.row_mut(at + n).copy_from(&((own - &mean) * root).transpose());
    }
    let count = rows.nrows();
    (mean, qr_with_rhs(rows, DVector::zeros(count)).r)
}

/// `to += weight · A Aᵀ` for upper triangular A.
fn add_square(to: &mut DMatrix<f64>, a: &DMatrix<f64>, weight: f64) {
    let n = a.ncols();
    for j in 0..n {
        for i in 0..=j {
            let sum: f64 = (j..n).map(|k| a[(i, k)] * a[(j, k)]).sum();
            to[(i, j)] += weight * sum;
            if i < j {
                to[(j, i)] += weight * sum;
            }
        }
    }
}
