//! Figures of an estimate that is filtered along oblique directions: `Â_λ = Z diag(f) Z⁻¹ Â` in the
//! scaled columns, with `fᵢ = 1/(1 + λδᵢ)` where the nodes see the direction and 0 where they do
//! not.
//!
//! Along zᵢ the least-squares coefficient aᵢ has variance σ². The squared error in the scaled
//! columns is no sum over directions, since they are not at right angles:
//!
//! `predicted_mse = ‖Z (1−f)ã‖² + σ² Σ fᵢ² ‖zᵢ‖²`, `ãᵢ = sign(aᵢ) √max(aᵢ² − σ², 0)`,
//!
//! which is the sum of the orthogonal case where Z is orthogonal. The bias of the expectation is `M
//! A`, `M = Z diag(1−f) Z⁻¹`, so `r ‖M‖₂` bounds it sharply; M is not symmetric and ‖M‖₂ may exceed
//! 1.

use nalgebra::{DMatrix, DVector};

use super::pair::product;
use crate::numerics::{Dd, Real, jacobi, root::boundary, svd_dd};

/// The directions in the scaled columns.
pub(super) struct Oblique {
    /// Column i is zᵢ.
    pub z: DMatrix<f64>,
    /// Z⁻¹.
    inverse: DMatrix<Dd>,
    z_exact: DMatrix<Dd>,
    /// Z⁻ᵀ, for largest eigenvalues.
    dual: DMatrix<f64>,
    /// δᵢ.
    pub delta: Vec<f64>,
    /// Directions before this one are not seen by the nodes.
    pub silent: usize,
    /// Z⁻¹ Â.
    pub a: Vec<f64>,
    /// ãᵢ.
    real: DVector<f64>,
    /// ‖zᵢ‖².
    lengths: Vec<f64>,
    variance: Option<f64>,
}

impl Oblique {
    /// Directions `z` with their inverse, and the least-squares coefficients along them.
    pub(super) fn new(
        z: DMatrix<Dd>,
        inverse: DMatrix<Dd>,
        delta: Vec<f64>,
        silent: usize,
        a: Vec<f64>,
        variance: Option<f64>,
    ) -> Self {
        let plain = z.map(|x| x.to_f64());
        let noise = variance.unwrap_or(0.0);
        Oblique {
            lengths: plain.column_iter().map(|column| column.norm_squared()).collect(),
            real: DVector::from_iterator(
                a.len(),
                a.iter().enumerate().map(|(i, &a)| match i < silent {
                    true => 0.0,
                    false => (a * a - noise).max(0.0).sqrt().copysign(a),
                }),
            ),
            dual: inverse.transpose().map(|x| x.to_f64()),
            z: plain,
            z_exact: z,
            inverse,
            delta,
            silent,
            a,
            variance,
        }
    }

    /// The same directions with other least-squares coefficients and another σ².
    pub(super) fn with(&self, a: Vec<f64>, variance: f64) -> Self {
        let (z, inverse) = (self.z_exact.clone(), self.inverse.clone());
        Oblique::new(z, inverse, self.delta.clone(), self.silent, a, Some(variance))
    }

    /// Whether no σ is known.
    pub(super) fn is_noiseless(&self) -> bool {
        self.variance.is_none()
    }

    fn size(&self) -> usize {
        self.delta.len()
    }

    /// fᵢ.
    pub(super) fn factor(&self, i: usize, lambda: f64) -> f64 {
        if i < self.silent { 0.0 } else { 1.0 / (1.0 + lambda * self.delta[i]) }
    }

    /// 1 − fᵢ, without cancellation.
    pub(super) fn removed(&self, i: usize, lambda: f64) -> f64 {
        let pull = lambda * self.delta[i];
        match i < self.silent {
            true => 1.0,
            false if pull.is_finite() => pull / (1.0 + pull),
            false => 1.0,
        }
    }

    fn each(&self, f: impl Fn(usize) -> f64) -> DVector<f64> {
        DVector::from_fn(self.size(), |i, _| f(i))
    }

    /// `‖Â − Â_λ‖`.
    pub(super) fn bias(&self, lambda: f64) -> f64 {
        (&self.z * self.each(|i| self.removed(i, lambda) * self.a[i])).norm()
    }

    /// `‖Â_λ‖`.
    pub(super) fn norm(&self, lambda: f64) -> f64 {
        (&self.z * self.each(|i| self.factor(i, lambda) * self.a[i])).norm()
    }

    /// `‖Y − XÂ_λ‖² − RSS`.
    pub(super) fn risen(&self, lambda: f64) -> f64 {
        (self.silent..self.size()).map(|i| (self.removed(i, lambda) * self.a[i]).powi(2)).sum()
    }

    /// The predicted mean squared error and its derivative by ln λ; `None` without σ.
    pub(super) fn mse(&self, lambda: f64) -> Option<(f64, f64)> {
        let variance = self.variance?;
        let moved = &self.z * self.each(|i| self.removed(i, lambda) * self.real[i]);
        let slope = &self.z * self.each(|i| self.factor(i, lambda) * self.removed(i, lambda) * self.real[i]);
        let (mut noise, mut falling) = (0.0, 0.0);
        for i in self.silent..self.size() {
            let (f, g) = (self.factor(i, lambda), self.removed(i, lambda));
            noise += f * f * self.lengths[i];
            falling += f * f * g * self.lengths[i];
        }
        Some((moved.norm_squared() + variance * noise, 2.0 * (moved.dot(&slope) - variance * falling)))
    }

    /// `X̃ᵀX̃ + λP` in the directions: 1 + λδ, or λδ where the nodes see nothing.
    fn lifted(&self, i: usize, lambda: f64) -> f64 {
        lambda * self.delta[i] + if i < self.silent { 0.0 } else { 1.0 }
    }

    /// Whether every `1 + λδ` is a number that can be worked with.
    pub(super) fn within_range(&self, lambda: f64) -> bool {
        (0..self.size()).all(|i| (1e-280..1e280).contains(&self.lifted(i, lambda)))
    }

    /// Eigenvalues of `X̃ᵀX̃ + λP`, ascending; `None` if the iteration does not end.
    pub(super) fn eigenvalues(&self, lambda: f64) -> Option<Vec<f64>> {
        /// Relative error that double precision may leave.
        const TOLERANCE: f64 = 1e-12;
        let roots: Vec<Dd> = (0..self.size()).map(|i| Dd::from(self.lifted(i, lambda)).sqrt()).collect();
        let rows = DMatrix::from_fn(self.size(), self.size(), |i, j| roots[i] * self.inverse[(i, j)]);
        let plain = jacobi::svd(rows.map(|x| x.to_f64()))?;
        let (low, high) = (plain.sigma.first().copied()?, plain.sigma.last().copied()?);
        if low > 0.0 && high / low * f64::EPSILON * self.size() as f64 <= TOLERANCE {
            return Some(plain.sigma.iter().map(|s| s * s).collect());
        }
        Some(svd_dd(&rows)?.sigma.iter().map(|&s| (s * s).to_f64()).collect())
    }

    /// Condition of `X̃ᵀX̃ + λP` and the derivative of its logarithm by ln λ. Its largest
    /// eigenvalue is a convex function of λ and its smallest a concave one, so this slope changes
    /// its sign at most once.
    pub(super) fn condition(&self, lambda: f64) -> Option<(f64, f64)> {
        let lifted = self.each(|i| self.lifted(i, lambda));
        let (high, x) = largest(&self.dual, &lifted);
        let (low, y) = largest(&self.z, &lifted.map(|g| 1.0 / g));
        let share = |i: usize| lambda * self.delta[i];
        // derivatives of the two Rayleigh quotients
        let rising: f64 = (0..x.len()).map(|i| share(i) * x[i] * x[i]).sum::<f64>() / high;
        let lifting: f64 = (0..y.len()).map(|i| share(i) / (lifted[i] * lifted[i]) * y[i] * y[i]).sum::<f64>() / low;
        let condition = high * low;
        (condition.is_finite() && condition > 0.0).then_some((condition, rising - lifting))
    }

    /// `M = Z diag(1−f) Z⁻¹`, formed in double-double: Z may be long where M is not.
    pub(super) fn removal(&self, lambda: f64) -> DMatrix<f64> {
        let mut turned = self.inverse.clone();
        for (i, mut row) in turned.row_iter_mut().enumerate() {
            let removed = self.removed(i, lambda);
            row.iter_mut().for_each(|x| *x = x.mul_f64(removed));
        }
        product(&self.z_exact, &turned).map(|x| x.to_f64())
    }
}

/// `‖M‖₂`.
pub(super) fn spectral_norm(matrix: &DMatrix<f64>) -> f64 {
    let ones = DVector::from_element(matrix.ncols(), 1.0);
    largest(matrix, &ones).0.sqrt()
}

/// Steps of the iteration at most, and the residual at which it ends.
const STEPS: usize = 60;
const SETTLED: f64 = 1e-13;
const INVERSE_STEPS: usize = 3;

/// The largest eigenvalue of `M diag(d) Mᵀ`, d > 0, with `Mᵀx` for its eigenvector x of length 1.
///
/// Lanczos' iteration, every vector made orthogonal to all before it; at most 60 steps, or as many
/// as there are rows.
fn largest(matrix: &DMatrix<f64>, d: &DVector<f64>) -> (f64, DVector<f64>) {
    let n = matrix.nrows();
    let scale = matrix.amax();
    if !(scale > 0.0) || !scale.is_finite() {
        return (0.0, DVector::zeros(matrix.ncols()));
    }
    let apply = |x: &DVector<f64>| matrix * matrix.tr_mul(x).component_mul(d);
    // a start that no symmetry of the problem can make orthogonal to the eigenvector sought
    let mut x = DVector::from_fn(n, |i, _| 1.0 + (1.7 * i as f64 + 0.3).sin());
    x /= x.norm();
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let (mut diagonal, mut beside): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    let (mut value, mut ritz) = (0.0, vec![1.0]);
    for step in 0..STEPS.min(n) {
        let mut next = apply(&x);
        let own = next.dot(&x);
        diagonal.push(own);
        basis.push(x.clone());
        for _ in 0..2 {
            for known in &basis {
                let share = next.dot(known);
                next.axpy(-share, known, 1.0);
            }
        }
        let length = next.norm();
        (value, ritz) = top(&diagonal, &beside);
        if length * ritz[step].abs() <= SETTLED * value.abs() || length == 0.0 {
            break;
        }
        beside.push(length);
        x = next / length;
    }
    let mut vector = DVector::zeros(n);
    for (share, known) in ritz.iter().zip(&basis) {
        vector.axpy(*share, known, 1.0);
    }
    (value, matrix.tr_mul(&vector))
}

/// The largest eigenvalue of a symmetric tridiagonal matrix and its vector of length 1: bisection
/// on whether `xI − T` has pivots all positive, then inverse iteration with the first x that has.
fn top(diagonal: &[f64], beside: &[f64]) -> (f64, Vec<f64>) {
    let n = diagonal.len();
    let off = |i: usize| beside.get(i).map_or(0.0, |b| b.abs());
    let reach = (0..n).map(|i| diagonal[i] + off(i) + if i > 0 { off(i - 1) } else { 0.0 });
    let mut above = reach.fold(f64::NEG_INFINITY, f64::max);
    above += above.abs() * 1e-15 + f64::MIN_POSITIVE;
    let below = diagonal.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut pivots = vec![0.0; n];
    let positive = |x: f64, pivots: &mut Vec<f64>| {
        let mut last = 1.0;
        for i in 0..n {
            let carried = if i > 0 { beside[i - 1] * (beside[i - 1] / last) } else { 0.0 };
            last = x - diagonal[i] - carried;
            pivots[i] = last;
            if !(last > 0.0) {
                return false;
            }
        }
        true
    };
    let [_, above] = boundary([below, above], 0.0, |x| !positive(x, &mut pivots));
    let mut vector = vec![1.0; n];
    if positive(above, &mut pivots) {
        for _ in 0..INVERSE_STEPS {
            for i in 1..n {
                vector[i] += beside[i - 1] / pivots[i - 1] * vector[i - 1];
            }
            for i in (0..n).rev() {
                vector[i] = (vector[i] + if i + 1 < n { beside[i] * vector[i + 1] } else { 0.0 }) / pivots[i];
            }
            let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
            vector.iter_mut().for_each(|x| *x /= length);
        }
    }
    (above, vector)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_top_of_a_tridiagonal_matrix() {
        // 2 on the diagonal, 1 beside it: 2 + 2 cos(π/(n+1)), vector sin(πi/(n+1))
        let n = 7;
        let (value, vector) = top(&[2.0; 7], &[1.0; 6]);
        let angle = std::f64::consts::PI / (n as f64 + 1.0);
        assert!((value - 2.0 - 2.0 * angle.cos()).abs() < 1e-14);
        for (i, x) in vector.iter().enumerate() {
            assert!((x - ((i as f64 + 1.0) * angle).sin() * 0.5).abs() < 1e-13, "{vector:?}");
        }
        assert_eq!(top(&[3.0], &[]).1, [1.0]);
    }

    #[test]
    fn the_largest_eigenvalue_and_its_vector() {
        let matrix = DMatrix::from_fn(9, 9, |i, j| ((3 * i + 5 * j) as f64).cos());
        let d = DVector::from_fn(9, |i, _| 10f64.powi(i as i32 - 4));
        let full = &matrix * DMatrix::from_diagonal(&d) * matrix.transpose();
        let eigen = full.clone().symmetric_eigen();
        let (value, image) = largest(&matrix, &d);
        assert!((value / eigen.eigenvalues.max() - 1.0).abs() < 1e-11);
        let rayleigh: f64 = (0..9).map(|i| d[i] * image[i] * image[i]).sum();
        assert!((rayleigh / value - 1.0).abs() < 1e-11);
        assert_eq!(largest(&DMatrix::zeros(3, 3), &DVector::from_element(3, 1.0)).0, 0.0);
    }
}
