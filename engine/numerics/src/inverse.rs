//! The inverse of a matrix by Gaussian elimination, for large ones in steps that can be cancelled.

use nalgebra::{DMatrix, linalg};

use super::cancel;

/// Up to this size the whole takes less than a millisecond.
const SMALL: usize = 64;

/// The inverse of a square matrix, the same bits as nalgebra's; `None` where it is singular.
///
/// ```
/// use flankfit_numerics::inverse;
/// use nalgebra::DMatrix;
///
/// let a = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 0.0, 4.0]);
/// let expected = DMatrix::from_row_slice(2, 2, &[0.5, -0.125, 0.0, 0.25]);
/// assert!((inverse(a).unwrap() - expected).amax() < 1e-15);
/// assert!(inverse(DMatrix::zeros(2, 2)).is_none());
/// ```
pub fn inverse(mut a: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = a.nrows();
    if n <= SMALL {
        return a.try_inverse();
    }
    let mut inverse = DMatrix::identity(n, n);
    for i in 0..n {
        cancel::checkpoint();
        let pivot = a.view_range(i.., i).icamax() + i;
        let head = a[(pivot, i)];
        if head == 0.0 {
            return None;
        }
        if pivot == i {
            linalg::gauss_step(&mut a, head, i);
        } else {
            inverse.swap_rows(i, pivot);
            a.columns_range_mut(..i).swap_rows(i, pivot);
            linalg::gauss_step_swap(&mut a, head, i, pivot);
        }
    }
    for mut column in inverse.column_iter_mut() {
        cancel::checkpoint();
        if !a.solve_lower_triangular_with_diag_mut(&mut column, 1.0) || !a.solve_upper_triangular_mut(&mut column) {
            return None;
        }
    }
    Some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_matrices_have_the_bits_of_nalgebra() {
        for n in [65usize, 150] {
            let mut state = 1u64;
            let a = DMatrix::from_fn(n, n, |_, _| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
            });
            let (own, theirs) = (inverse(a.clone()).unwrap(), a.try_inverse().unwrap());
            assert!(own.iter().zip(theirs.iter()).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
        assert_eq!(inverse(DMatrix::zeros(70, 70)), None);
    }
}
