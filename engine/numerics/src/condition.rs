//! The condition number of a matrix that is only known by what it does to vectors.
//!
//! The largest singular value of `A` and of `A⁻¹` by the bidiagonalisation of Golub and Kahan,
//! every vector made orthogonal to all before it. As many steps as rows give the value itself; for
//! larger matrices [`STEPS`] of them come within about 1e-6 of it, from below.

use nalgebra::DMatrix;

use super::cancel;
use super::jacobi::svd;

/// The most steps that are taken.
pub const STEPS: usize = 96;

/// Between two looks at whether the value still grows.
const STRIDE: usize = 8;

/// Largest singular value of the `size × size` matrix behind `forward` (A x) and `transposed` (Aᵀ
/// x), both in place. None if it is not finite.
pub fn largest_singular_value(
    size: usize,
    mut forward: impl FnMut(&mut [f64]),
    mut transposed: impl FnMut(&mut [f64]),
) -> Option<f64> {
    let mut v = start(size);
    scale(&mut v)?;
    let (mut lefts, mut rights): (Vec<Vec<f64>>, Vec<Vec<f64>>) = (Vec::new(), vec![v.clone()]);
    // the bidiagonal matrix: `alpha` on its diagonal, `beta` above
    let (mut alpha, mut beta): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    let mut value = 0.0;
    let steps = size.min(STEPS);
    for step in 1..=steps {
        cancel::checkpoint();
        let mut u = v.clone();
        forward(&mut u);
        finite(&u)?;
        orthogonalise(&mut u, &lefts);
        alpha.push(scale(&mut u).unwrap_or(0.0));
        let mut w = u.clone();
        transposed(&mut w);
        finite(&w)?;
        lefts.push(u);
        orthogonalise(&mut w, &rights);
        let next = scale(&mut w);
        let last = step == steps || next.is_none();
        if last || step % STRIDE == 0 {
            let before = value;
            value = bidiagonal_norm(&alpha, &beta)?;
            if last || value - before <= 1e-13 * value {
                return Some(value);
            }
        }
        beta.push(next?);
        rights.push(w.clone());
        v = w;
    }
    None
}

/// A start without symmetry, so that no singular vector is missed: the fractions of multiples of
/// the golden ratio.
fn start(size: usize) -> Vec<f64> {
    (1..=size).map(|i| (i as f64 * 0.618_033_988_749_894_9).fract() - 0.45).collect()
}

fn finite(v: &[f64]) -> Option<()> {
    v.iter().all(|x| x.is_finite()).then_some(())
}

/// Scales to length 1 and returns the length, if that is a number above 0.
fn scale(v: &mut [f64]) -> Option<f64> {
    let largest = v.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    if !(largest > 0.0) {
        return None;
    }
    let length = largest * v.iter().map(|x| (x / largest).powi(2)).sum::<f64>().sqrt();
    v.iter_mut().for_each(|x| *x /= length);
    length.is_finite().then_some(length)
}

/// Takes the parts along `others` (orthonormal) away, twice, and everything if only rounding is
/// left.
fn orthogonalise(v: &mut [f64], others: &[Vec<f64>]) {
    let length = |v: &[f64]| v.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let before = length(v);
    for _ in 0..2 {
        for other in others {
            let along: f64 = v.iter().zip(other).map(|(a, b)| a * b).sum();
            v.iter_mut().zip(other).for_each(|(a, b)| *a -= along * b);
        }
    }
    if length(v) <= 1e-14 * before {
        v.fill(0.0);
    }
}

fn bidiagonal_norm(alpha: &[f64], beta: &[f64]) -> Option<f64> {
    let n = alpha.len();
    let matrix = DMatrix::from_fn(n, n, |i, j| match j {
        _ if i == j => alpha[i],
        _ if j == i + 1 => beta[i],
        _ => 0.0,
    });
    svd(matrix)?.sigma.last().copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_diagonal_matrix() {
        for size in [1usize, 2, 7, 300] {
            let scale = |v: &mut [f64]| v.iter_mut().enumerate().for_each(|(i, x)| *x *= 1.0 + i as f64);
            let value = largest_singular_value(size, scale, scale).unwrap();
            assert!((value / size as f64 - 1.0).abs() < 1e-6, "{size} {value}");
        }
    }

    #[test]
    fn overflow_has_no_largest_singular_value() {
        let huge = |v: &mut [f64]| v.iter_mut().for_each(|x| *x *= f64::MAX * 8.0);
        assert_eq!(largest_singular_value(3, huge, huge), None);
    }
}
