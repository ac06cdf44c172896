//! The nodes seen from least squares: orthonormal rows and what least squares left.
//!
//! Row k is `qₖ = R⁻ᵀ √wₖ wₖ`, so that `QᵀQ = I` however the columns were conditioned, and `bₖ =
//! √wₖ rₖ` are the residuals of least squares. An estimator that is not a reweighting looks for the
//! step `x` with least loss of `b − Qx`; the coefficients in the working basis are then those of
//! least squares plus `R⁻¹x`.

use super::outcome::Measured;
use crate::{
    error::FitError,
    factor::{Precision, Wanted, orthonormal_rows, residual_pass},
};
use flankfit_numerics::{cancel::Asking, check::Faults, triangular};

/// Numbers that rows may hold: 160 MB.
const MOST: usize = 20_000_000;

/// Rows and heights of a problem, row by row.
pub(super) struct Rows {
    pub n: usize,
    pub q: Vec<f64>,
    pub b: Vec<f64>,
}

impl Rows {
    /// The rows of all counted nodes; refuses more numbers than memory should hold.
    pub(super) fn new(measured: &Measured) -> Result<Self, FitError> {
        let Measured { linear, sample, .. } = *measured;
        let (design, factor) = (linear.design, linear.factor);
        let (m, n) = (sample.count(), design.size());
        if m * n > MOST {
            return Err(Faults::one(
                "estimator.type",
                format_args!(
                    "this estimator needs {m} nodes × {n} coefficients in memory; at most {MOST} numbers are \
                     possible: use `m_estimator`, or fewer nodes"
                ),
            )
            .into());
        }
        let working = factor.working.as_deref().unwrap_or(&[]);
        let q = orthonormal_rows(design, factor, sample);
        let precision = if m * n <= 2_000_000 { Precision::DoubleDouble } else { Precision::Double };
        let residuals = residual_pass(design, sample, working, precision, Wanted::Values).values;
        let b = residuals.iter().enumerate().map(|(k, r)| r * sample.w(k).sqrt()).collect();
        Ok(Rows { n, q, b })
    }

    /// m.
    pub(super) fn count(&self) -> usize {
        self.b.len()
    }

    /// qₖ.
    pub(super) fn row(&self, k: usize) -> &[f64] {
        &self.q[k * self.n..][..self.n]
    }

    /// `b − Qx`.
    pub(super) fn residuals(&self, x: &[f64]) -> Vec<f64> {
        self.b.iter().zip(self.q.chunks_exact(self.n)).asking(self.n).map(|(b, q)| b - dot(q, x)).collect()
    }
}

/// Σ aᵢbᵢ, in four sums side by side.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (fours, others) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = fours.remainder().iter().zip(others.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; 4];
    for (a, b) in fours.zip(others) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}

/// The factor of weighted normal equations `Σ ωₖ qₖqₖᵀ`.
pub(super) struct Normal {
    length: Vec<f64>,
    factor: nalgebra::DMatrix<f64>,
}

impl Normal {
    /// `None` where the weights leave too little.
    pub(super) fn new(n: usize, q: &[f64], weights: &[f64]) -> Option<Self> {
        let mut gram = nalgebra::DMatrix::<f64>::zeros(n, n);
        let (fours, four_weights) = (q.chunks_exact(4 * n.max(1)), weights.chunks_exact(4));
        let rest = fours.remainder().chunks_exact(n.max(1)).zip(four_weights.remainder());
        for (rows, w) in fours.zip(four_weights).asking(4 * n * n) {
            let row = |k: usize| &rows[k * n..(k + 1) * n];
            let rows = [row(0), row(1), row(2), row(3)];
            for (i, column) in gram.as_mut_slice().chunks_exact_mut(n).enumerate() {
                let share: [f64; 4] = std::array::from_fn(|k| w[k] * rows[k][i]);
                let others = rows[0].iter().zip(rows[1]).zip(rows[2].iter().zip(rows[3]));
                for (to, ((a, b), (c, d))) in column[..=i].iter_mut().zip(others) {
                    *to += (share[0] * a + share[1] * b) + (share[2] * c + share[3] * d);
                }
            }
        }
        for (row, &w) in rest.asking(n * n) {
            for (i, column) in gram.as_mut_slice().chunks_exact_mut(n).enumerate() {
                column[..=i].iter_mut().zip(row).for_each(|(to, x)| *to += w * row[i] * x);
            }
        }
        let length: Vec<f64> = (0..n).map(|i| gram[(i, i)].sqrt()).collect();
        if length.iter().any(|d| !(*d > 0.0 && d.is_finite())) {
            return None;
        }
        let unit = nalgebra::DMatrix::from_fn(n, n, |i, j| gram[(i.min(j), i.max(j))] / (length[i] * length[j]));
        let factor = triangular::cholesky(&unit)?;
        if (0..n).any(|i| factor[(i, i)] < 1e-7) {
            return None;
        }
        Some(Normal { length, factor })
    }

    /// `y` whose product with itself is that of `q` with the inverse between.
    pub(super) fn whitened(&self, q: &[f64]) -> Vec<f64> {
        let mut y: Vec<f64> = q.iter().zip(&self.length).map(|(q, d)| q / d).collect();
        triangular::solve_upper_transposed(&self.factor, &mut y);
        y
    }

    /// Solves for a right-hand side.
    pub(super) fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut x = self.whitened(right);
        triangular::solve_upper(&self.factor, &mut x);
        x.iter_mut().zip(&self.length).for_each(|(x, d)| *x /= d);
        x
    }
}

/// Solves the weighted normal equations `(Σ ωₖ qₖqₖᵀ) x = Σ ωₖ qₖ yₖ`; `None` where the weights
/// leave too little.
pub(super) fn weighted_solution(n: usize, q: &[f64], weights: &[f64], y: &[f64]) -> Option<Vec<f64>> {
    let normal = Normal::new(n, q, weights)?;
    let mut right = vec![0.0; n];
    for ((row, &w), &y) in q.chunks_exact(n).zip(weights).zip(y).asking(n).filter(|((_, w), _)| **w != 0.0) {
        right.iter_mut().zip(row).for_each(|(to, x)| *to += w * x * y);
    }
    Some(normal.solve(&right))
}
