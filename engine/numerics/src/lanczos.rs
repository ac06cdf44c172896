//! The largest eigenvalue of a symmetric positive semidefinite operator that can only be applied
//! (Lanczos, with the basis kept orthogonal throughout).

use super::{
    cancel::{self, Asking},
    length,
    tridiagonal::ql,
};

/// Applications of the operator at most.
const MOST: usize = 400;
/// Applications between two looks at the small eigenproblem.
const STRIDE: usize = 12;
/// Residual of the eigenvector at the end, relative to the eigenvalue, whose own error is of the
/// second order in it.
const TOLERANCE: f64 = 1e-7;

/// The largest eigenvalue of the operator `apply` on vectors of length `size`; `None` where it is
/// not found within the limit. The same operator gives the same bits: the start is a fixed sequence
/// of numbers.
pub fn largest_eigenvalue(size: usize, apply: impl Fn(&[f64]) -> Vec<f64>) -> Option<f64> {
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
    let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
    for step in 1..=MOST.min(size) {
        cancel::checkpoint();
        let here = &basis[step - 1];
        let mut next = apply(here);
        diagonal.push(here.iter().zip(&next).map(|(a, b)| a * b).sum::<f64>());
        for _ in 0..2 {
            for q in basis.iter().asking(2 * size) {
                let share: f64 = q.iter().zip(&next).map(|(a, b)| a * b).sum();
                next.iter_mut().zip(q).for_each(|(to, q)| *to -= share * q);
            }
        }
        let rest = length(&next);
        let scale = diagonal.iter().fold(0.0f64, |a: f64, d: &f64| a.max(d.abs()));
        let ended = step == size || !(rest > 1e-14 * scale);
        if ended || step % STRIDE == 0 {
            let (value, last) = top(&diagonal, &off_diagonal);
            if !value.is_finite() {
                return None;
            }
            if ended || rest * last.abs() <= TOLERANCE * value.abs() {
                return Some(value);
            }
        }
        next.iter_mut().for_each(|x| *x /= rest);
        off_diagonal.push(rest);
        basis.push(next);
    }
    None
}

/// The largest eigenvalue of a symmetric tridiagonal matrix and the last entry of its eigenvector:
/// implicit QL steps, of whose rotations only the last row is gathered (Golub and Welsch, Math.
/// Comp. 23, 1969), so that the work is of the second order in the size.
fn top(diagonal: &[f64], off_diagonal: &[f64]) -> (f64, f64) {
    let k = diagonal.len();
    let (mut d, mut e, mut last) = (diagonal.to_vec(), off_diagonal.to_vec(), vec![0.0; k]);
    e.truncate(k - 1);
    e.push(0.0);
    last[k - 1] = 1.0;
    let turn = |i: usize, c: f64, s: f64| {
        (last[i], last[i + 1]) = (c * last[i] - s * last[i + 1], s * last[i] + c * last[i + 1]);
    };
    if ql(&mut d, &mut e, turn).is_none() {
        return (f64::NAN, 0.0);
    }
    let best = (0..k).fold(0, |best, j| if d[j] > d[best] { j } else { best });
    (d[best], last[best])
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, SymmetricEigen};

    use super::*;
    use crate::cancel::{Cancelled, Handle};

    fn tridiagonal(k: usize) -> (Vec<f64>, Vec<f64>) {
        let wave = |i: usize, turn: f64| (turn * i as f64).sin();
        ((0..k).map(|i| wave(i, 1.3)).collect(), (1..k).map(|i| 0.5 + 0.4 * wave(i, 2.1)).collect())
    }

    #[test]
    fn the_top_of_a_tridiagonal_matrix_is_that_of_the_full_one() {
        for k in [1, 2, 3, 12, 60, 150] {
            let (diagonal, off_diagonal) = tridiagonal(k);
            let full = DMatrix::from_fn(k, k, |i, j| match i.abs_diff(j) {
                0 => diagonal[i],
                1 => off_diagonal[i.min(j)],
                _ => 0.0,
            });
            let eigen = SymmetricEigen::new(full);
            let best = eigen.eigenvalues.imax();
            let (value, last) = top(&diagonal, &off_diagonal);
            assert!((value - eigen.eigenvalues[best]).abs() < 1e-13, "{k}: {value}");
            assert!((last.abs() - eigen.eigenvectors[(k - 1, best)].abs()).abs() < 1e-12, "{k}: {last}");
        }
        assert_eq!(top(&[1.0, 3.0, 2.0], &[0.0, 0.0]), (3.0, 0.0), "a matrix that falls into parts");
        assert!(top(&[1.0, f64::NAN, 2.0], &[1.0, 1.0]).0.is_nan());
    }

    #[test]
    fn the_small_problem_can_be_given_up() {
        let (diagonal, off_diagonal) = tridiagonal(3000);
        let part = Handle::with_checkpoints(1000).run(|| top(&diagonal, &off_diagonal));
        assert_eq!(part, Err(Cancelled));
    }

    #[test]
    fn the_largest_of_a_second_difference() {
        // 2 on the diagonal, −1 next to it: eigenvalues 2 − 2 cos(kπ/(n+1))
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
