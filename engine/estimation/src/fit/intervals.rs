//! Confidence intervals of the coefficients of a fit.

use crate::{
    estimate::directions,
    inference::{Inferred, LinearForm, Noise, bias_aware},
    result::{BiasReport, Interval, IntervalKind, NormLimitSource},
    spectrum::{ScaledColumns, Spectrum},
};
use flankfit_numerics::cancel::Asking;

/// Parts of the intervals other than the coefficients themselves.
pub(super) struct Intervals<'a> {
    pub columns: &'a ScaledColumns,
    pub spectrum: &'a Spectrum,
    pub noise: Noise,
    /// r, where it was given before the nodes were seen.
    pub norm_limit: Option<f64>,
    /// Kind of Student's intervals: about the estimate itself or about least squares.
    pub unlimited: IntervalKind,
}

/// r of `bias` where the nodes had no part in it.
pub(super) fn given_limit(bias: &BiasReport) -> Option<f64> {
    match bias.coefficient_norm_limit_source {
        NormLimitSource::Request | NormLimitSource::Limits => Some(bias.coefficient_norm_limit),
        NormLimitSource::Estimate | NormLimitSource::Heights | NormLimitSource::Prior => None,
    }
}

impl Intervals<'_> {
    /// Intervals of each coefficient, given its unregularised estimates and their standard errors;
    /// `None` where nothing limits a coefficient.
    pub(super) fn of(&self, value: &[f64], std_error: impl Fn(usize) -> Option<f64>) -> Vec<Option<Interval>> {
        let n = value.len();
        let quantile = self.noise.quantile();
        let rows = (self.norm_limit.is_some() || !self.spectrum.full_rank())
            .then(|| directions(self.columns, &self.spectrum.v, n));
        let mut along = vec![0.0; self.spectrum.lambda.len()];
        (0..n)
            .asking(16 * n)
            .map(|j| {
                if let Some(rows) = &rows {
                    along.iter_mut().zip(rows.row(j).iter()).for_each(|(to, &p)| *to = p);
                }
                let determined = rows.is_none() || self.estimable(&along);
                let error = std_error(j).filter(|error| (quantile * error).is_finite() && determined);
                let plain = error.map(|error| quantile * error);
                let about = |value, std_error, bias_bound| Inferred {
                    value,
                    std_error,
                    bias_bound,
                    student: self.noise.student,
                    ..Inferred::default()
                };
                let student = plain.zip(error).map(|(half, error)| (about(value[j], error, 0.0), half, self.unlimited));
                let aware = self.norm_limit.map(|r| {
                    let found = bias_aware(&self.form(j, &along), r, &self.noise);
                    let about = about(found.value, found.std_error, found.bias_bound);
                    (about, found.half_width, IntervalKind::BiasAware)
                });
                // both widths know no heights but σ̂, so taking the shorter costs no coverage
                let plain_value = value[j];
                let (about, half, kind) = match (student, aware) {
                    (Some(student), Some(aware)) => {
                        if aware.1 < student.1 {
                            aware
                        } else {
                            student
                        }
                    }
                    (student, aware) => student.or(aware)?,
                };
                let gain = plain.filter(|plain| self.norm_limit.is_some() && *plain > 0.0).map(|plain| half / plain);
                let ends = [about.value - half, about.value + half];
                let least_squares = match (kind, plain) {
                    (IntervalKind::BiasAware, Some(plain)) => Some([plain_value - plain, plain_value + plain]),
                    _ => None,
                };
                Some(Interval { ends, kind, about, least_squares, gain })
            })
            .collect()
    }

    /// Coefficient j along the eigenvectors.
    fn form<'a>(&'a self, j: usize, along: &'a [f64]) -> LinearForm<'a> {
        let constant = self.columns.constant.as_ref().filter(|constant| constant.index == j);
        LinearForm {
            along,
            lambda: &self.spectrum.lambda,
            a: &self.spectrum.a,
            constant: constant.map_or(0.0, |_| self.spectrum.level.to_f64()),
            constant_variance: constant.map_or(0.0, |constant| 1.0 / constant.length_squared),
        }
    }

    /// True if the nodes determine a form: it has nothing along directions with eigenvalue 0.
    fn estimable(&self, along: &[f64]) -> bool {
        /// Share of the form's length that rounding may leave there.
        const ROUNDING: f64 = 1e-9;
        let length = |blind: bool| {
            let terms = along.iter().zip(&self.spectrum.lambda).filter(|(_, lambda)| !blind || **lambda == 0.0);
            terms.map(|(p, _)| p * p).sum::<f64>().sqrt()
        };
        length(true) <= ROUNDING * length(false)
    }
}
