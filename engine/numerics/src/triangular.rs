//! Upper triangular matrices: Cholesky factor, solves, inverse, product.
//!
//! All loops run down columns, which is how the entries lie. Only the upper triangle is ever read.
//! A zero on the diagonal makes a solve answer with infinities or NaN; whoever may meet one looks
//! at the diagonal first.

use nalgebra::DMatrix;

use super::cancel;
use super::real::Real;

/// The upper triangular `R` of positive diagonal with `RᵀR = G`, from the upper triangle of `g`.
///
/// None if a pivot is not above `n * EPSILON * g_jj`, where rounding could have made it up, or is
/// not finite.
///
/// ```
/// use flankfit_numerics::triangular::cholesky;
/// use nalgebra::DMatrix;
///
/// // RᵀR = G with R = [[2, 1], [0, 3]].
/// let g = DMatrix::from_row_slice(2, 2, &[4.0, 2.0, 2.0, 10.0_f64]);
/// let r = cholesky(&g).unwrap();
/// assert_eq!([r[(0, 0)], r[(0, 1)], r[(1, 1)]], [2.0, 1.0, 3.0]);
/// ```
pub fn cholesky<T: Real>(g: &DMatrix<T>) -> Option<DMatrix<T>> {
    let n = g.ncols();
    let mut r = DMatrix::<T>::zeros(n, n);
    for j in 0..n {
        cancel::every(4 * n * n, j);
        let (done, rest) = r.as_mut_slice().split_at_mut(j * n);
        let column = &mut rest[..n];
        for i in 0..j {
            let above = &done[i * n..i * n + i + 1];
            let inner = dot(&above[..i], &column[..i]);
            column[i] = (g[(i, j)] - inner) / above[i];
        }
        let pivot = g[(j, j)] - dot(&column[..j], &column[..j]);
        if !pivot.is_finite() || pivot <= g[(j, j)].mul_f64(n as f64 * T::EPSILON) {
            return None;
        }
        column[j] = pivot.sqrt();
    }
    Some(r)
}

/// Solves `R x = b` in place.
pub fn solve_upper<T: Real>(r: &DMatrix<T>, b: &mut [T]) {
    for j in (0..b.len()).rev() {
        let column = column(r, j);
        let x = b[j] / column[j];
        b[j] = x;
        for (b, &r) in b[..j].iter_mut().zip(column) {
            *b = (-x).fma(r, *b);
        }
    }
}

/// Solves `Rᵀ x = b` in place.
pub fn solve_upper_transposed<T: Real>(r: &DMatrix<T>, b: &mut [T]) {
    solve_upper_transposed_from(r, 0, b);
}

/// The same where the numbers of `b` before `first` are 0, and so those of `x`.
pub fn solve_upper_transposed_from<T: Real>(r: &DMatrix<T>, first: usize, b: &mut [T]) {
    for j in first..b.len() {
        let column = column(r, j);
        b[j] = (b[j] - dot(&column[first..j], &b[first..j])) / column[j];
    }
}

/// The inverse, upper triangular again.
pub fn inverse_upper<T: Real>(r: &DMatrix<T>) -> DMatrix<T> {
    let n = r.ncols();
    let mut inverse = DMatrix::<T>::zeros(n, n);
    for (j, column) in inverse.as_mut_slice().chunks_exact_mut(n.max(1)).enumerate() {
        cancel::every(4 * n * n, j);
        column[j] = T::one();
        solve_upper(r, &mut column[..=j]);
    }
    inverse
}

/// The product `A B` of two upper triangular matrices of one size.
pub fn multiply_upper<T: Real>(a: &DMatrix<T>, b: &DMatrix<T>) -> DMatrix<T> {
    let n = a.ncols();
    let mut product = DMatrix::<T>::zeros(n, n);
    for (j, column_j) in product.as_mut_slice().chunks_exact_mut(n.max(1)).enumerate() {
        cancel::every(4 * n * n, j);
        for k in 0..=j {
            let factor = b[(k, j)];
            for (out, &a) in column_j.iter_mut().zip(&column(a, k)[..=k]) {
                *out = factor.fma(a, *out);
            }
        }
    }
    product
}

#[inline(always)]
fn column<T: Real>(matrix: &DMatrix<T>, j: usize) -> &[T] {
    let rows = matrix.nrows();
    &matrix.as_slice()[j * rows..(j + 1) * rows]
}

#[inline(always)]
fn dot<T: Real>(x: &[T], y: &[T]) -> T {
    x.iter().zip(y).fold(T::zero(), |sum, (&x, &y)| x.fma(y, sum))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dd::Dd;
    use proptest::prelude::*;

    fn upper() -> impl Strategy<Value = DMatrix<f64>> {
        (1usize..8).prop_flat_map(|n| {
            prop::collection::vec(-1.0..1.0f64, n * n).prop_map(move |entries| {
                DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
                    std::cmp::Ordering::Less => entries[j * n + i],
                    std::cmp::Ordering::Equal => 1.5 + entries[j * n + i],
                    std::cmp::Ordering::Greater => 0.0,
                })
            })
        })
    }

    fn close<T: Real>(a: &DMatrix<T>, b: &DMatrix<T>, bound: f64) -> bool {
        a.iter().zip(b.iter()).all(|(&x, &y)| (x - y).abs().to_f64() <= bound * T::EPSILON)
    }

    fn laws<T: Real>(r: &DMatrix<T>) {
        let n = r.ncols();
        let inverse = inverse_upper(r);
        let size = inverse.iter().map(|x| x.abs().to_f64()).fold(1.0, f64::max);
        let identity = DMatrix::from_fn(n, n, |i, j| if i == j { T::one() } else { T::zero() });
        assert!(close(&multiply_upper(r, &inverse), &identity, 200.0 * size));
        assert!(close(&multiply_upper(&inverse, r), &identity, 200.0 * size * size));
        let product = |x: &[T], transposed: bool| -> Vec<T> {
            (0..n)
                .map(|i| {
                    (0..n).fold(T::zero(), |sum, j| (if transposed { r[(j, i)] } else { r[(i, j)] }).fma(x[j], sum))
                })
                .collect()
        };
        let b: Vec<T> = (0..n).map(|i| T::of((i as f64).sin())).collect();
        for transposed in [false, true] {
            let mut x = b.clone();
            if transposed {
                solve_upper_transposed(r, &mut x)
            } else {
                solve_upper(r, &mut x)
            }
            for (back, b) in product(&x, transposed).iter().zip(&b) {
                assert!((*back - *b).abs().to_f64() <= 200.0 * size * size * T::EPSILON);
            }
        }
        let gram = DMatrix::from_fn(n, n, |i, j| (0..n).fold(T::zero(), |sum, k| r[(k, i)].fma(r[(k, j)], sum)));
        let factor = cholesky(&gram).expect("positive definite");
        assert!(close(&factor, r, 1000.0 * size * size));
    }

    #[test]
    fn indefinite_matrices_have_no_cholesky_factor() {
        assert_eq!(cholesky(&DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 4.0])), None);
        assert_eq!(cholesky(&DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 3.0])), None);
        assert_eq!(cholesky(&DMatrix::from_row_slice(1, 1, &[f64::NAN])), None);
        assert_eq!(cholesky(&DMatrix::from_row_slice(1, 1, &[f64::INFINITY])), None);
        assert_eq!(cholesky(&DMatrix::from_row_slice(1, 1, &[0.0])), None);
        assert_eq!(cholesky(&DMatrix::from_row_slice(1, 1, &[4.0])), Some(DMatrix::from_element(1, 1, 2.0)));
    }

    #[test]
    fn a_pivot_that_only_double_double_can_see() {
        let close_to_singular = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0 + f64::EPSILON]);
        assert_eq!(cholesky(&close_to_singular), None);
        let factor = cholesky(&close_to_singular.map(Dd::from)).expect("positive definite");
        assert!((factor[(1, 1)] - Dd::from(f64::EPSILON).sqrt()).abs().hi < 1e-24);
    }

    #[test]
    fn a_leading_block_is_solved_by_a_shorter_slice() {
        let r = DMatrix::from_row_slice(3, 3, &[2.0, 1.0, 9.0, 0.0, 4.0, 9.0, 0.0, 0.0, 0.0]);
        let mut b = [4.0, 8.0];
        solve_upper(&r, &mut b);
        assert_eq!(b, [1.0, 2.0]);
        solve_upper_transposed(&r, &mut b);
        assert_eq!(b, [0.5, 0.375]);
        assert_eq!(inverse_upper(&DMatrix::<f64>::zeros(0, 0)).shape(), (0, 0));
    }

    proptest! {
        #[test]
        fn solves_and_products_undo_each_other(r in upper()) {
            laws(&r);
            laws(&r.map(Dd::from));
        }
    }
}
