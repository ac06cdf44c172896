//! Information on the coefficients, as rows `R δ = d` with independent errors of variance 1.
//!
//! Everything is done by orthogonal transformations of such rows, so that no covariance is ever
//! inverted and no product of matrices formed (square-root information filter; Bierman 1977).

use nalgebra::{DMatrix, DVector};

use crate::factor::multiply_upper_vector;
use flankfit_numerics::{cancel, qr_with_rhs, triangular};

/// Rows `R δ = d`, R upper triangular.
#[derive(Clone, Debug)]
pub(super) struct Information {
    pub r: DMatrix<f64>,
    pub d: DVector<f64>,
}

/// Spread of a move: `δ' = δ + shift + B w` with w of covariance 1.
pub(super) enum Spread {
    /// B = q · 1.
    Even(f64),
    /// B, upper triangular.
    Of(DMatrix<f64>),
}

impl Information {
    /// n.
    pub(super) fn size(&self) -> usize {
        self.d.len()
    }

    /// Information after a move, and `ln |det W|`, W being the information on w. With w for δ, the
    /// rows are `w = 0` and `R(δ' − shift − B w) = d`; w is eliminated.
    pub(super) fn moved(&self, shift: &DVector<f64>, spread: &Spread) -> (Self, f64) {
        let n = self.size();
        let mut image = shift.clone();
        multiply_upper_vector(&self.r, image.as_mut_slice());
        let d = &self.d + image;
        let mixed = match spread {
            Spread::Even(0.0) => return (Information { r: self.r.clone(), d }, 0.0),
            Spread::Even(q) => &self.r * *q,
            Spread::Of(b) => triangular::multiply_upper(&self.r, b),
        };
        cancel::every(40 * n * n * n, 0);
        let mut rows = DMatrix::zeros(2 * n, 2 * n);
        rows.view_mut((0, 0), (n, n)).fill_with_identity();
        rows.view_mut((n, 0), (n, n)).copy_from(&-mixed);
        rows.view_mut((n, n), (n, n)).copy_from(&self.r);
        let mut right = DVector::zeros(2 * n);
        right.rows_mut(n, n).copy_from(&d);
        let found = qr_with_rhs(rows, right);
        let ln_w = (0..n).map(|i| found.r[(i, i)].abs().ln()).sum();
        let r = found.r.view((n, n), (n, n)).into_owned();
        (Information { r, d: found.qty.rows(n, n).into_owned() }, ln_w)
    }

    /// Together with further rows, and the square of what they contradict each other by: with a
    /// prediction of covariance P and new rows of n numbers this is `eᵀS⁻¹e`.
    pub(super) fn with(&self, other: &Information) -> (Self, f64) {
        let n = self.size();
        cancel::every(20 * n * n * n, 0);
        let mut rows = DMatrix::zeros(2 * n, n);
        rows.view_mut((0, 0), (n, n)).copy_from(&self.r);
        rows.view_mut((n, 0), (n, n)).copy_from(&other.r);
        let mut right = DVector::zeros(2 * n);
        right.rows_mut(0, n).copy_from(&self.d);
        right.rows_mut(n, n).copy_from(&other.d);
        let found = qr_with_rhs(rows, right);
        (Information { r: found.r, d: found.qty }, found.rss)
    }

    /// `ln |det R|`.
    pub(super) fn ln_determinant(&self) -> f64 {
        (0..self.size()).map(|i| self.r[(i, i)].abs().ln()).sum()
    }

    /// True if δ is determined.
    pub(super) fn is_whole(&self) -> bool {
        /// Rounding error on the diagonal, relative to the length of its column.
        const ROUNDING: f64 = 1e-12;
        (0..self.size()).all(|i| self.r[(i, i)].abs() > ROUNDING * self.r.column(i).norm())
    }

    /// The mean of δ, where it is determined.
    pub(super) fn mean(&self) -> DVector<f64> {
        let mut mean = self.d.clone();
        triangular::solve_upper(&self.r, mean.as_mut_slice());
        mean
    }

    /// `R⁻¹`: the covariance of δ is `R⁻¹R⁻ᵀ`.
    pub(super) fn inverse(&self) -> DMatrix<f64> {
        triangular::inverse_upper(&self.r)
    }
}
