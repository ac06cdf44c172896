//! Standard errors and intervals that do not follow from σ and R alone.

use nalgebra::DMatrix;

use super::{
    mixture::{Mixture, lower_root},
    sandwich::Sandwich,
    variance_spread::VarianceSpread,
};
use crate::{
    factor::Factor,
    inference::{CONFORMANCE_PROBABILITY, Inferred, Noise},
};
use flankfit_numerics::{Dd, distribution::Student, length, triangular};

/// The covariance of what the heights have in Q's coordinates, and what it is of.
pub(crate) struct ErrorSpread {
    /// A root G of the covariance: a form q has variance ‖Gᵀq‖².
    root: DMatrix<f64>,
    kind: Kind,
}

enum Kind {
    /// Student's distribution with m − n degrees of freedom.
    Student,
    /// A mixture, with the matrix that leads from Q's coordinates to those of plain least squares.
    Mixture(Mixture, DMatrix<f64>),
    /// Student's distribution with each form's own degrees of freedom.
    Variances(VarianceSpread),
    /// The same, about least squares of nodes with unknown variances.
    Sandwich(Sandwich),
}

impl ErrorSpread {
    /// Spread of a covariance in Q's coordinates, given by its root.
    pub(crate) fn new(root: DMatrix<f64>) -> Self {
        ErrorSpread { root, kind: Kind::Student }
    }

    /// Spread of a mixture found in the coordinates of the factor `plain`, for a problem whose
    /// factor is `white`; `None` where its covariance is singular to rounding.
    pub(crate) fn of_mixture(mixture: Mixture, white: &DMatrix<Dd>, plain: &Factor) -> Option<Self> {
        let inverse = triangular::inverse_upper(&plain.r);
        let turn = triangular::multiply_upper(white, &inverse).map(|x| x.to_f64());
        Some(ErrorSpread { root: &turn * mixture.root()?, kind: Kind::Mixture(mixture, turn) })
    }

    /// Spread with estimated variances; σ of the weighted problem. `None` where the covariance is
    /// singular to rounding.
    pub(crate) fn of_variances(variances: VarianceSpread, sigma: f64) -> Option<Self> {
        Some(ErrorSpread { root: variances.root()? * sigma, kind: Kind::Variances(variances) })
    }

    /// Spread of least squares with unknown variances of the nodes. `None` where the covariance is
    /// singular to rounding.
    pub(crate) fn of_sandwich(sandwich: Sandwich) -> Option<Self> {
        Some(ErrorSpread { root: lower_root(&sandwich.covariance())?, kind: Kind::Sandwich(sandwich) })
    }

    /// True if errors are those of R but for a factor, so that unit vectors of a tube are R's.
    pub(crate) fn is_weighted(&self) -> bool {
        matches!(self.kind, Kind::Variances(_))
    }

    /// The noise with the distribution that the error of a form has over its standard error.
    pub(crate) fn noise_of(&self, form: &[f64], noise: &Noise) -> Noise {
        let student: Student = match &self.kind {
            Kind::Variances(variances) => variances.student(form),
            Kind::Sandwich(sandwich) => sandwich.student(form),
            Kind::Student | Kind::Mixture(..) => noise.student,
        };
        Noise { student, ..*noise }
    }

    /// A vector whose products with those of other forms are their covariances.
    pub(crate) fn root_of_row(&self, row: &[f64]) -> Vec<f64> {
        self.root.column_iter().map(|column| column.iter().zip(row).map(|(g, q)| g * q).sum()).collect()
    }

    /// Standard error of a form.
    pub(crate) fn of_row(&self, row: &[f64]) -> f64 {
        length(&self.root_of_row(row))
    }

    /// The interval of an unregularised form with this value, where errors are a mixture; `own` is
    /// the standard deviation of a further error in σ.
    pub(crate) fn interval(&self, form: &[f64], value: f64, own: f64, miss: f64) -> Option<[f64; 2]> {
        let Kind::Mixture(mixture, turn) = &self.kind else { return None };
        let plain: Vec<f64> =
            turn.column_iter().map(|column| column.iter().zip(form).map(|(t, q)| t * q).sum()).collect();
        Some(mixture.interval(&plain, value, own, miss))
    }

    /// Distribution of the error of an unregularised form. Decisions use the tails of
    /// [`CONFORMANCE_PROBABILITY`]: a mixture is replaced by Student's distribution with the same
    /// ones.
    pub(crate) fn inferred(&self, form: &[f64], value: f64, noise: &Noise) -> Inferred {
        let student = self.noise_of(form, noise).student;
        let tail = 1.0 - CONFORMANCE_PROBABILITY;
        let (value, std_error) = match self.interval(form, value, 0.0, 2.0 * tail) {
            Some([low, high]) => (0.5 * (low + high), 0.5 * (high - low) / student.upper_quantile(tail)),
            None => (value, self.of_row(form)),
        };
        Inferred { value, std_error, student, ..Inferred::default() }
    }
}
