//! What follows from the noise: intervals of the coefficients, their covariance, predictions.

use super::{
    conclude::Solved,
    forms::Forms,
    intervals::{self, Intervals},
    predict::{outside, predictions},
};
use crate::estimation::{
    inference::{Inferred, Noise},
    prior::PooledNoise,
    regularized::Applied,
    result::{Covariance, Interval, IntervalKind, Predictions, RegularizationKind, Warning},
};

impl Solved<'_> {
    /// What is known of the noise: σ that was told, else σ̂.
    pub(super) fn noise(&self, level: f64) -> Option<Noise> {
        match self.spec.noise_sigma {
            Some(sigma) => Some(Noise::known(sigma, level)),
            None => self.noise.map(|sigma| Noise::estimated(sigma, self.degrees_of_freedom as f64, level)),
        }
    }

    /// Covariance matrices and predictions, where they were asked for.
    pub(super) fn forms(
        &self,
        applied: &Applied,
        warnings: &mut Vec<Warning>,
    ) -> (Option<Covariance>, Option<Predictions>) {
        let (spec, predict) = (self.spec, self.spec.predict.as_ref());
        if !spec.include.covariance && predict.is_none() {
            return (None, None);
        }
        if !self.spectrum.full_rank() {
            warnings.push(Warning::NoPredictions);
            return (None, None);
        }
        let level = predict.and_then(|asked| asked.level).unwrap_or(spec.level);
        let pooled = applied.pooled().map(|pooled| noise_of(pooled, level));
        let forms = Forms {
            linear: self.linear,
            columns: &self.frame.columns,
            spectrum: &self.spectrum,
            map: &applied.map,
            fitted: applied.map.fitted(self.linear, &self.spectrum),
            noise: pooled.or_else(|| self.noise(level)),
            posterior: pooled.is_some(),
            robust: self.robust.map(|robust| &robust.estimate.spread),
            told: intervals::told(&applied.bias).filter(|_| self.robust.is_none()),
            norm_limit: applied.bias.coefficient_norm_limit,
        };
        let covariance = spec.include.covariance.then(|| forms.covariance(&applied.estimate.coefficients)).flatten();
        if let Some(outside) = predict.map(|asked| outside(self.linear.design, &asked.at)).filter(|count| *count > 0) {
            warnings.push(Warning::OutsideDomain(outside));
        }
        let predictions = predict.map(|asked| predictions(&forms, asked, level));
        (covariance, predictions)
    }

    /// Confidence intervals of the coefficients: none without an estimate of the noise.
    pub(super) fn intervals(&self, applied: &Applied) -> Vec<Option<Interval>> {
        if let Some(pooled) = applied.pooled() {
            return self.posterior_intervals(applied, &noise_of(pooled, self.spec.level));
        }
        let Some(noise) = self.noise(self.spec.level) else { return Vec::new() };
        let plain = matches!(applied.regularization.kind, RegularizationKind::None);
        let intervals = Intervals {
            columns: &self.frame.columns,
            spectrum: &self.spectrum,
            noise,
            // the bound on the bias is of filters of least squares
            norm_limit: intervals::told(&applied.bias).filter(|_| self.robust.is_none()),
            unlimited: if plain { IntervalKind::Student } else { IntervalKind::LeastSquares },
        };
        let value = &self.least_squares.coefficients;
        match self.robust {
            None => intervals.of(value, |j| Some(noise.sigma * applied.estimate.leverage[j])),
            Some(robust) => {
                let (spectrum, columns, factor) = (&self.spectrum, &self.frame.columns, self.linear.factor);
                let errors = robust.estimate.spread.of_unregularized(value.len(), spectrum, columns, factor);
                intervals.of(value, |j| errors[j].filter(|_| self.degrees_of_freedom > 0))
            }
        }
    }

    /// Student's interval about the mean of the posterior, and that about least squares by the
    /// nodes alone.
    fn posterior_intervals(&self, applied: &Applied, noise: &Noise) -> Vec<Option<Interval>> {
        let alone = self.noise(self.spec.level);
        let of = |j: usize| {
            let (value, std_error) = (applied.estimate.coefficients[j], noise.sigma * applied.estimate.spread[j]);
            let half = noise.quantile() * std_error;
            let plain = alone.map(|alone| alone.quantile() * alone.sigma * applied.estimate.leverage[j]);
            let middle = self.least_squares.coefficients[j];
            Some(Interval {
                ends: [value - half, value + half],
                kind: IntervalKind::Posterior,
                about: Inferred { value, std_error, bias_bound: 0.0, student: noise.student },
                least_squares: plain.map(|plain| [middle - plain, middle + plain]),
                gain: plain.filter(|plain| *plain > 0.0).map(|plain| half / plain),
            })
        };
        (0..applied.estimate.coefficients.len()).map(of).collect()
    }
}

/// The noise by which a posterior was weighed.
fn noise_of(pooled: PooledNoise, level: f64) -> Noise {
    match pooled.freedom {
        None => Noise::known(pooled.sigma, level),
        Some(freedom) => Noise::estimated(pooled.sigma, freedom as f64, level),
    }
}
