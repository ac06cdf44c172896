//! Standard errors of a robust estimate, plain and regularised.
//!
//! The unregularised estimate has covariance `τ² (XᵀX)⁻¹`, X with the node weights only. In the
//! problem that was solved the caller's columns are `R_ω`, those of X are `R`, and the filtered
//! estimate is linear in the unfiltered one, so that row j of its square root is `τ (Σᵢ Pⱼᵢ fᵢ/λᵢ ·
//! image_iᵀ) G` with `G = R_ω R⁻¹` in the working basis, where nothing cancels.

use nalgebra::DMatrix;

use super::{outcome::Along, rows::dot};
use crate::{
    estimate::{Estimate, directions},
    factor::Factor,
    result::RegularizationReport,
    spectrum::{ScaledColumns, Spectrum, caller_columns},
};
use flankfit_numerics::{cancel::Asking, triangular};

/// Parts of the standard errors.
pub(crate) struct Spread {
    dispersion: Option<f64>,
    along: Option<Along>,
    /// `R_ω R⁻¹`; `None` where they are the same.
    turn: Option<DMatrix<f64>>,
}

impl Spread {
    pub(crate) fn new(
        factor: &Factor,
        plain: &Factor,
        dispersion: Option<f64>,
        along: Option<Along>,
        weighted: bool,
    ) -> Self {
        let turn = weighted.then(|| {
            let inverse = triangular::inverse_upper(&plain.r);
            triangular::multiply_upper(&factor.r, &inverse).map(|x| x.to_f64())
        });
        Spread { dispersion, along, turn }
    }

    /// The same with standard errors `by` times as large; `None` for none at all.
    pub(crate) fn widened(self, by: Option<f64>) -> Self {
        let along = self.along.zip(by).map(|(along, by)| Along { dispersion: by * along.dispersion, ..along });
        Spread { dispersion: self.dispersion.zip(by).map(|(tau, by)| by * tau), along, ..self }
    }

    /// σ of a height of weight 1 in the problem that was solved: τ² times the mean of ω over the
    /// directions of X.
    pub(crate) fn sigma(&self) -> Option<f64> {
        let mean = self.turn.as_ref().map_or(1.0, |turn| turn.norm_squared() / turn.ncols() as f64);
        self.dispersion.map(|tau| tau * mean.sqrt())
    }

    /// Standard errors of `estimate`, regularised as `regularization` says.
    ///
    /// They are exact if the filter acts along the eigenvectors. If it acts along other directions
    /// (Tikhonov), or toward a target, those of the unregularised estimate shrink in the proportion
    /// in which regularisation shrinks `(XᵀX)⁻¹`.
    pub(crate) fn standard_errors(
        &self,
        estimate: &Estimate,
        spectrum: &Spectrum,
        columns: &ScaledColumns,
        factor: &Factor,
        regularization: &RegularizationReport,
    ) -> Vec<Option<f64>> {
        let n = estimate.coefficients.len();
        if regularization.kind.filters_eigenvectors() {
            return self.filtered(n, Some(&regularization.filter_factors), spectrum, columns, factor);
        }
        let mut errors = self.filtered(n, None, spectrum, columns, factor);
        for (j, error) in errors.iter_mut().enumerate() {
            let shrunk = estimate.spread[j] / estimate.leverage[j];
            *error = error.map(|e| e * shrunk).filter(|e| e.is_finite());
        }
        errors
    }

    /// Standard errors of the n coefficients before they are regularised.
    pub(crate) fn of_unregularized(
        &self,
        n: usize,
        spectrum: &Spectrum,
        columns: &ScaledColumns,
        factor: &Factor,
    ) -> Vec<Option<f64>> {
        self.filtered(n, None, spectrum, columns, factor)
    }

    /// Standard errors of the estimate that `factors` filter along the eigenvectors.
    fn filtered(
        &self,
        n: usize,
        factors: Option<&[f64]>,
        spectrum: &Spectrum,
        columns: &ScaledColumns,
        factor: &Factor,
    ) -> Vec<Option<f64>> {
        let directions = directions(columns, &spectrum.v, n);
        let constant = columns.constant.as_ref().map(|constant| {
            let all = caller_columns(factor);
            let column: Vec<f64> = all.column(constant.index).iter().map(|x| x.to_f64()).collect();
            (constant.index, constant.length_squared, column)
        });
        (0..n)
            .asking(n * n)
            .map(|j| {
                let mut row = vec![0.0; n];
                for (i, &lambda) in spectrum.lambda.iter().enumerate().filter(|(_, lambda)| **lambda > 0.0) {
                    let share = directions[(j, i)] * factors.map_or(1.0, |f| f[i]) / lambda;
                    row.iter_mut().zip(spectrum.image.column(i).iter()).for_each(|(r, x)| *r += share * x);
                }
                if let Some((index, length_squared, column)) = &constant
                    && *index == j
                {
                    row.iter_mut().zip(column).for_each(|(r, x)| *r += x / length_squared);
                }
                self.of_row(row).filter(|e| e.is_finite())
            })
            .collect()
    }

    /// √ of the variance of a linear form, given in Q's coordinates of the problem that was solved.
    pub(crate) fn of_row(&self, row: Vec<f64>) -> Option<f64> {
        let tau = self.dispersion?;
        let row = self.turned(row);
        let mut variance = tau * tau * dot(&row, &row);
        if let Some(along) = &self.along {
            let share = dot(&row, &along.direction);
            variance += (along.dispersion * along.dispersion - tau * tau) * share * share;
        }
        Some(variance.max(0.0).sqrt())
    }

    /// A vector whose products with those of other forms are their covariances.
    pub(crate) fn root_of_row(&self, row: Vec<f64>) -> Option<Vec<f64>> {
        let tau = self.dispersion?;
        let mut row = self.turned(row);
        let share = self.along.as_ref().map_or(0.0, |along| dot(&row, &along.direction));
        row.iter_mut().for_each(|x| *x *= tau);
        if let Some(along) = &self.along {
            let more = (along.dispersion - tau) * share;
            row.iter_mut().zip(&along.direction).for_each(|(x, d)| *x += more * d);
        }
        Some(row)
    }

    fn turned(&self, row: Vec<f64>) -> Vec<f64> {
        match &self.turn {
            Some(turn) => turn.column_iter().map(|column| dot(column.as_slice(), &row)).collect(),
            None => row,
        }
    }
}
