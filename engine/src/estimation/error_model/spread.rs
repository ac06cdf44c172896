//! Standard errors and intervals that do not follow from σ and R alone.

use nalgebra::DMatrix;

use super::mixture::Mixture;
use crate::{
    estimation::{
        factor::Factor,
        inference::{CONFORMANCE_PROBABILITY, Inferred, Noise},
    },
    numerics::{Dd, triangular},
};

/// The covariance of what the heights have in Q's coordinates, and the mixture that it is of.
pub(crate) struct ErrorSpread {
    /// A root G of the covariance: a form q has variance ‖Gᵀq‖².
    root: DMatrix<f64>,
    /// With the matrix that leads from Q's coordinates to those of plain least squares.
    mixture: Option<(Mixture, DMatrix<f64>)>,
}

impl ErrorSpread {
    /// Of a covariance in Q's coordinates, given by its root.
    pub(crate) fn new(root: DMatrix<f64>) -> Self {
        ErrorSpread { root, mixture: None }
    }

    /// Of a mixture found in the coordinates of the factor `plain`, for a problem whose factor is
    /// `white`; `None` where its covariance is singular to rounding.
    pub(crate) fn of_mixture(mixture: Mixture, white: &DMatrix<Dd>, plain: &Factor) -> Option<Self> {
        let inverse = triangular::inverse_upper(&plain.r);
        let turn = triangular::multiply_upper(white, &inverse).map(|x| x.to_f64());
        Some(ErrorSpread { root: &turn * mixture.root()?, mixture: Some((mixture, turn)) })
    }

    /// A vector whose products with those of other forms are their covariances.
    pub(crate) fn root_of_row(&self, row: &[f64]) -> Vec<f64> {
        self.root.column_iter().map(|column| column.iter().zip(row).map(|(g, q)| g * q).sum()).collect()
    }

    /// Standard error of a form.
    pub(crate) fn of_row(&self, row: &[f64]) -> f64 {
        self.root_of_row(row).iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// The interval of an unregularised form with this value, where errors are a mixture; `own` is
    /// the standard deviation of a further error in σ.
    pub(crate) fn interval(&self, form: &[f64], value: f64, own: f64, miss: f64) -> Option<[f64; 2]> {
        let (mixture, turn) = self.mixture.as_ref()?;
        let plain: Vec<f64> =
            turn.column_iter().map(|column| column.iter().zip(form).map(|(t, q)| t * q).sum()).collect();
        Some(mixture.interval(&plain, value, own, miss))
    }

    /// What is known of the error of an unregularised form. Decisions ask for the tails of
    /// [`CONFORMANCE_PROBABILITY`]: a mixture is answered as Student's distribution with the same
    /// ones.
    pub(crate) fn inferred(&self, form: &[f64], value: f64, noise: &Noise) -> Inferred {
        let student = noise.student;
        let tail = 1.0 - CONFORMANCE_PROBABILITY;
        let (value, std_error) = match self.interval(form, value, 0.0, 2.0 * tail) {
            Some([low, high]) => (0.5 * (low + high), 0.5 * (high - low) / student.upper_quantile(tail)),
            None => (value, self.of_row(form)),
        };
        Inferred { value, std_error, bias_bound: 0.0, student }
    }
}
