//! Sums over the fitted curve or surface.

use super::{
    conclude::Solved,
    forms::{Estimated, Forms},
};
use crate::{
    design::Along,
    inference::{Inferred, bias_aware},
    regularized::Applied,
    result::{Interval, IntervalKind, WeightedSum},
};
use flankfit_numerics::{Dd, Real, cancel::Asking};

impl Solved<'_> {
    /// Requested sums, each a linear form of the coefficients: the weighted sum of the rows of its
    /// places.
    pub(super) fn sums(&self, applied: &Applied) -> Option<Vec<Option<WeightedSum>>> {
        let asked = self.spec.sums.as_ref()?;
        let design = self.linear.design;
        if design.domain.is_none() || !self.spectrum.full_rank() {
            return None;
        }
        let n = design.size();
        let rows: Vec<Vec<Dd>> =
            asked.places.iter().asking(n).map(|place| design.row_at(*place, Along::Value)).collect();
        let forms = self.forms_at(applied, self.spec.level);
        let unlimited = if applied.map.is_identity() { IntervalKind::Student } else { IntervalKind::LeastSquares };
        let sum = |weights: &Vec<f64>| {
            let mut row = vec![Dd::ZERO; n];
            for (at, &weight) in rows.iter().zip(weights) {
                row.iter_mut().zip(at).for_each(|(to, &x)| *to += x.mul_f64(weight));
            }
            let found = forms.of_row(row);
            let sum = WeightedSum {
                value: found.value,
                std_error: forms.std_error(&found),
                conditional_std_error: forms.conditional_std_error(&found),
                bias_bound: found.bias_bound,
                least_squares: forms.least_squares(&found.form),
                interval: forms.interval_of(&found, unlimited),
            };
            Some(sum).filter(WeightedSum::is_finite)
        };
        Some(asked.weights.iter().asking(n * (n + rows.len())).map(sum).collect())
    }
}

impl Forms<'_> {
    /// The interval of a form with what it is made of; `unlimited` is its kind where nothing limits
    /// the coefficients.
    fn interval_of(&self, one: &Estimated, unlimited: IntervalKind) -> Option<Interval> {
        let (ends, noise) = (self.interval(one, 0.0)?, self.noise_of(&one.form)?);
        let of = |kind, about| Some(Interval { ends, kind, about, least_squares: None, gain: None });
        let plain = |value, std_error| Inferred { value, std_error, student: noise.student, ..Inferred::default() };
        if self.posterior {
            return of(IntervalKind::Posterior, plain(one.value, one.conditional_error?));
        }
        if let Some(about) = self.inferred(&one.form) {
            return of(unlimited, about);
        }
        let error = one.least_squares_error?;
        // as `interval` chooses
        if let Some(r) = self.given_limit {
            let found = bias_aware(&self.along(&one.form), r, &noise);
            if found.half_width < noise.quantile() * error {
                let about = Inferred { bias_bound: found.bias_bound, ..plain(found.value, found.std_error) };
                return of(IntervalKind::BiasAware, about);
            }
        }
        of(unlimited, plain(self.least_squares(&one.form), error))
    }
}
