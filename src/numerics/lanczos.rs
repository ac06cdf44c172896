//! The largest eigenvalue of a symmetric positive semidefinite operator that can only be applied (Lanczos, with the basis kept
//! orthogonal throughout).

use nalgebra::{DMatrix, SymmetricEigen};

use super::cancel;

/// Applications of the operator at most.
const MOST: usize = 400;
/// Applications between two looks at the small eigenproblem.
const STRIDE: usize = 12;
/// Residual of the eigenvector at the end, relative to the eigenvalue, whose own error is of the second order in it.
const TOLERANCE: f64 = 1e-7;

/// The largest eigenvalue of the operator `apply` on vectors of length `size`; `None` where it is not found within the limit.
/// The same operator gives the same bits: the start is a fixed sequence of numbers.
pub fn largest_eigenvalue(size: usize, apply: impl Fn(&[f64]) -> Vec<f64>) -> Option<f64> {
    let length = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut start: Vec<f64> = (0..size)
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            // in ±[1, 2), so that no entry is 0
            let sign = if state >> 63 == 0 { 1.0 } else { -1.0 };
            sign * (1.0 + (state >> 12 & 0xfff_ffff) as f64 / f64::from(1 << 28))
        })
        .collect();
    let norm = length(&start);
    start.iter_mut().for_each(|x| *x /= norm);
    let mut basis = vec![start];
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    for step in 1..=MOST.min(size) {
        cancel::checkpoint();
        let here = &basis[step - 1];
        let mut next = apply(here);
        diagonal.push(here.iter().zip(&next).map(|(a, b)| a * b).sum::<f64>());
        for _ in 0..2 {
            for q in &basis {
                let share: f64 = q.iter().zip(&next).map(|(a, b)| a * b).sum();
                next.iter_mut().zip(q).for_each(|(to, q)| *to -= share * q);
            }
        }
        let rest = length(&next);
        let scale = diagonal.iter().fold(0.0f64, |a: f64, d: &f64| a.max(d.abs()));
        let ended = step == size || !(rest > 1e-14 * scale);
        if ended || step % STRIDE == 0 {
            let (value, last) = top(&diagonal, &beside);
            if !value.is_finite() {
                return None;
            }
            if ended || rest * last.abs() <= TOLERANCE * value.abs() {
                return Some(value);
            }
        }
        next.iter_mut().for_each(|x| *x /= rest);
        beside.push(rest);
        basis.push(next);
    }
    None
}

/// The largest eigenvalue of a tridiagonal matrix and the last entry of its eigenvector.
fn top(diagonal: &[f64], beside: &[f64]) -> (f64, f64) {
    let k = diagonal.len();
    let matrix = DMatrix::from_fn(k, k, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => beside[i.min(j)],
        _ => 0.0,
    });
    let Some(eigen) = SymmetricEigen::try_new(matrix, f64::EPSILON, 100 * k) else { return (f64::NAN, 0.0) };
    let best = eigen.eigenvalues.imax();
    (eigen.eigenvalues[best], eigen.eigenvectors[(k - 1, best)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_of_a_second_difference() {
        // 2, −1 beside it: eigenvalues 2 − 2 cos(kπ/(n+1))
        let n = 150;
        let found = largest_eigenvalue(n, |x| {
            (0..n)
                .map(|i| {
                    let at = |j: usize| x.get(j).copied().unwrap_or(0.0);
                    2.0 * x[i] - at(i.wrapping_sub(1)) - at(i + 1)
                })
                .collect()
        })
        .unwrap();
        let truth = 2.0 - 2.0 * (n as f64 * std::f64::consts::PI / (n as f64 + 1.0)).cos();
        assert!((found - truth).abs() < 1e-9, "{found} {truth}");
        assert_eq!(largest_eigenvalue(1, |x| vec![3.0 * x[0]]), Some(3.0));
        assert_eq!(largest_eigenvalue(4, |_| vec![f64::NAN; 4]), None);
        assert_eq!(largest_eigenvalue(4, |_| vec![0.0; 4]), Some(0.0));
    }
}
