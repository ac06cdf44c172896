//! Linear forms of the coefficients: their estimates, standard errors and intervals.

use nalgebra::DMatrix;

use crate::{
    design::Along,
    error_model::spread::ErrorSpread,
    inference::{CONFORMANCE_PROBABILITY, Inferred, LinearForm, Noise, bias_aware, half_width},
    prior::FormIntervals,
    problem::LinearProblem,
    regularized::{Form, LinearMap},
    result::Covariance,
    robust::Spread,
    spectrum::{ScaledColumns, Spectrum},
};
use flankfit_numerics::{Dd, Real, cancel::Asking, dot, length, triangular};

/// Parts of a fit from which linear forms of its coefficients are computed.
pub(super) struct Forms<'a> {
    pub linear: &'a LinearProblem<'a>,
    pub columns: &'a ScaledColumns,
    pub spectrum: &'a Spectrum,
    pub map: &'a LinearMap,
    /// The fitted heights in Q's coordinates.
    pub fitted: Vec<Dd>,
    pub noise: Option<Noise>,
    /// σ by which standard errors are, that of all iterations for a posterior.
    pub sigma: Option<f64>,
    /// Standard deviation of a further measurement; `None` where it has no band.
    pub further: Option<f64>,
    /// True if bands are those of a posterior, also after its prior was dropped.
    pub posterior: bool,
    /// Parts of the intervals of a posterior, if moves were estimated.
    pub posterior_intervals: Option<&'a FormIntervals>,
    /// Standard errors of a robust estimate.
    pub robust: Option<&'a Spread>,
    /// Covariances that do not follow from σ and R alone.
    pub errors: Option<&'a ErrorSpread>,
    /// r, where it was given before the nodes were seen.
    pub given_limit: Option<f64>,
    /// r, wherever it comes from.
    pub norm_limit: f64,
    /// True if the filter follows from the heights.
    pub chosen_by_heights: bool,
    /// True if standard errors of the estimate treat a λ* selected from the heights as given.
    pub conditional: bool,
}

/// A linear form with everything that bands are made of.
pub(super) struct Estimated {
    pub form: Form,
    pub value: f64,
    /// Standard errors of the estimate for the λ* used, and of least squares.
    pub conditional_error: Option<f64>,
    pub least_squares_error: Option<f64>,
    pub bias_bound: f64,
    /// σ times its length is the standard error.
    pub row: Vec<f64>,
}

impl Forms<'_> {
    /// The form whose row of the working matrix is `row`.
    pub(super) fn of_row(&self, mut row: Vec<Dd>) -> Estimated {
        triangular::solve_upper_transposed(&self.linear.factor.r, &mut row);
        let value = row.iter().zip(&self.fitted).fold(Dd::ZERO, |sum, (&q, &b)| sum + q * b).to_f64();
        self.estimated(Form::new(row.iter().map(|x| x.to_f64()).collect(), self.spectrum), value)
    }

    /// The sum of the caller's coefficients with these weights, `caller` being the caller's columns
    /// in Q's coordinates.
    pub(super) fn of_sum(&self, caller: &DMatrix<Dd>, mut weights: Vec<Dd>) -> Estimated {
        triangular::solve_upper_transposed(caller, &mut weights);
        let value = weights.iter().zip(&self.fitted).fold(Dd::ZERO, |sum, (&q, &b)| sum + q * b).to_f64();
        self.estimated(Form::new(weights.iter().map(|x| x.to_f64()).collect(), self.spectrum), value)
    }

    /// Height or slope at a place.
    pub(super) fn at(&self, place: [f64; 2], along: Along) -> Estimated {
        self.of_row(self.linear.design.row_at(place, along))
    }

    /// Estimates the height of a row of a measurement matrix.
    pub(super) fn at_row(&self, row: &[f64]) -> Estimated {
        self.of_row(self.linear.design.row_of(row))
    }

    /// Every coefficient of the caller.
    pub(super) fn coefficients(&self, values: &[f64]) -> Vec<Estimated> {
        let inverse =
            triangular::inverse_upper(&triangular::multiply_upper(&self.linear.factor.r, &self.linear.factor.change));
        let row = |j: usize| (0..values.len()).map(|k| if k < j { 0.0 } else { inverse[(j, k)].to_f64() }).collect();
        values.iter().enumerate().map(|(j, &value)| self.estimated(Form::new(row(j), self.spectrum), value)).collect()
    }

    /// Covariance matrices of the coefficients; `None` without an estimate of the noise.
    pub(super) fn covariance(&self, values: &[f64]) -> Option<Covariance> {
        let found = self.coefficients(values);
        let root = |row: &[f64]| match (self.robust, self.errors) {
            (Some(spread), _) => spread.root_of_row(row.to_vec()),
            (None, Some(errors)) => Some(errors.root_of_row(row)),
            (None, None) => self.sigma.map(|sigma| row.iter().map(|x| sigma * x).collect::<Vec<f64>>()),
        };
        let triangle = |rows: Vec<Vec<f64>>| -> Vec<Vec<f64>> {
            (0..rows.len())
                .asking(rows.len() * rows.len())
                .map(|j| (0..=j).map(|k| dot(&rows[j], &rows[k])).collect())
                .collect()
        };
        let of = |row: fn(&Estimated) -> &[f64]| {
            found.iter().map(|one| root(row(one))).collect::<Option<Vec<_>>>().map(triangle)
        };
        Some(Covariance { coefficients: of(|one| &one.row)?, least_squares: of(|one| &one.form.q)? })
    }

    /// Returns the valid standard error: that of least squares if λ* was selected from the heights.
    pub(super) fn std_error(&self, one: &Estimated) -> Option<f64> {
        if self.conditional { one.least_squares_error } else { one.conditional_error }
    }

    /// Returns the standard error conditional on the λ* used, if it is a different one.
    pub(super) fn conditional_std_error(&self, one: &Estimated) -> Option<f64> {
        one.conditional_error.filter(|_| self.conditional && one.conditional_error != one.least_squares_error)
    }

    fn estimated(&self, form: Form, value: f64) -> Estimated {
        let row = self.map.spread(&form, self.spectrum);
        let error = |row: &[f64]| match (self.robust, self.errors) {
            (Some(spread), _) => spread.of_row(row.to_vec()),
            (None, Some(errors)) => Some(errors.of_row(row)),
            (None, None) => self.sigma.map(|sigma| sigma * length(row)),
        };
        Estimated {
            value,
            conditional_error: error(&row),
            least_squares_error: error(&form.q),
            bias_bound: self.map.bias(&form, self.columns, self.norm_limit),
            row,
            form,
        }
    }

    /// Least squares of the form.
    pub(super) fn least_squares(&self, form: &Form) -> f64 {
        form.q.iter().zip(&self.linear.factor.qty).fold(Dd::ZERO, |sum, (&q, &b)| sum + b.mul_f64(q)).to_f64()
    }

    /// Distribution of the error of least squares of the form, if errors do not follow from σ and R
    /// alone.
    pub(super) fn inferred(&self, form: &Form) -> Option<Inferred> {
        Some(self.errors?.inferred(&form.q, self.least_squares(form), self.noise.as_ref()?))
    }

    /// Noise in the error of least squares of the form.
    pub(super) fn noise_of(&self, form: &Form) -> Option<Noise> {
        let noise = self.noise.as_ref()?;
        Some(self.errors.filter(|_| !self.posterior).map_or(*noise, |errors| errors.noise_of(&form.q, noise)))
    }

    /// The interval of the form at one place, widened for a further measurement whose own error is
    /// `own`: Student's about least squares, or the bias-aware one where that is shorter.
    pub(super) fn interval(&self, estimated: &Estimated, own: f64) -> Option<[f64; 2]> {
        let noise = &self.noise_of(&estimated.form)?;
        if self.posterior {
            return self.of_posterior(estimated, noise, own);
        }
        if let Some(errors) = self.errors {
            let value = self.least_squares(&estimated.form);
            let further = if own > 0.0 { own / noise.sigma } else { 0.0 };
            let found = errors.interval(&estimated.form.q, value, further, noise.miss);
            if found.is_some() {
                return found;
            }
        }
        let plain = noise.quantile() * estimated.least_squares_error?.hypot(own);
        let (mut middle, mut half) = (self.least_squares(&estimated.form), plain);
        if let Some(r) = self.given_limit {
            let found = bias_aware(&self.along(&estimated.form), r, noise);
            let aware = if own > 0.0 {
                half_width(noise, found.std_error.hypot(own), found.bias_bound)
            } else {
                found.half_width
            };
            if aware < half {
                (middle, half) = (found.value, aware);
            }
        }
        Some([middle - half, middle + half])
    }

    /// The interval about a posterior, widened for a further measurement whose own error is `own`.
    /// If moves were estimated it is about least squares with ends of its own, and the distances
    /// of the ends are combined with the further error each by itself (Zou and Donner, Statistics
    /// in Medicine 27, 2008); the returned value lies within.
    pub(super) fn of_posterior(&self, estimated: &Estimated, noise: &Noise, own: f64) -> Option<[f64; 2]> {
        let quantile = noise.quantile();
        let Some(intervals) = self.posterior_intervals else {
            let half = quantile * estimated.conditional_error?.hypot(own);
            return Some([estimated.value - half, estimated.value + half]);
        };
        let middle = self.least_squares(&estimated.form);
        let [low, high] = intervals.of(&estimated.form.q, noise).map(|end| (noise.sigma * end).hypot(quantile * own));
        Some([(middle - low).min(estimated.value), (middle + high).max(estimated.value)])
    }

    /// Distribution of the error of a posterior. Decisions use the tails of
    /// [`CONFORMANCE_PROBABILITY`]: an interval that misses by as much on both sides together
    /// misses by no more on either.
    pub(super) fn inferred_posterior(&self, estimated: &Estimated) -> Option<Inferred> {
        let noise = self.noise.as_ref()?;
        let student = noise.student;
        let known = |value, std_error| Some(Inferred { value, std_error, student, ..Inferred::default() });
        if self.posterior_intervals.is_none() {
            return known(estimated.value, estimated.conditional_error?);
        }
        let miss = 1.0 - CONFORMANCE_PROBABILITY;
        let [low, high] = self.of_posterior(estimated, &Noise { miss, ..*noise }, 0.0)?;
        known(0.5 * (low + high), 0.5 * (high - low) / student.upper_quantile(miss))
    }

    pub(super) fn along<'a>(&'a self, form: &'a Form) -> LinearForm<'a> {
        // what standardised columns leave unpenalised is the rest of the form
        let (constant, variance) = match &self.columns.constant {
            None => (0.0, 0.0),
            Some(_) => {
                let (mut rest, mut value) = (form.q.clone(), self.least_squares(form));
                for (i, (&p, &lambda)) in form.along.iter().zip(&self.spectrum.lambda).enumerate() {
                    if lambda > 0.0 {
                        let image = self.spectrum.image.column(i);
                        rest.iter_mut().zip(image.iter()).for_each(|(to, x)| *to -= p / lambda * x);
                        value -= p * self.spectrum.a[i];
                    }
                }
                (value, length(&rest).powi(2))
            }
        };
        LinearForm {
            along: &form.along,
            lambda: &self.spectrum.lambda,
            a: &self.spectrum.a,
            constant,
            constant_variance: variance,
        }
    }
}
