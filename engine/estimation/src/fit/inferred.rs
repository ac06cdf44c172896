//! Results that need the noise: intervals of the coefficients, their covariance, predictions.

use super::{
    conclude::Solved,
    forms::{Estimated, Forms},
    intervals::{self, Intervals},
    predict::{outside, predictions},
};
use crate::{
    inference::Noise,
    prior::PooledNoise,
    regularized::Applied,
    result::{Covariance, Interval, IntervalKind, Predictions, RegularizationKind, Warning},
    spec::{ChosenBy, Criterion, Estimator},
};

impl Solved<'_> {
    /// Noise of the nodes: the given σ, else σ̂. The dispersion of a robust estimate is estimated
    /// even if σ is given.
    pub(super) fn noise(&self, level: f64) -> Option<Noise> {
        match self.spec.noise_sigma.filter(|_| self.robust.is_none()) {
            Some(sigma) => Some(Noise::known(sigma, level)),
            None => self.noise.map(|sigma| Noise::estimated(sigma, self.degrees_of_freedom as f64, level)),
        }
    }

    /// Covariance matrices and predictions, if requested.
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
        let forms = self.forms_at(applied, level);
        let covariance = spec.include.covariance.then(|| forms.covariance(&applied.estimate.coefficients)).flatten();
        if let Some(outside) = predict.map(|asked| outside(self.linear.design, &asked.at)).filter(|count| *count > 0) {
            warnings.push(Warning::OutsideDomain { count: outside });
        }
        let quantile = matches!(spec.estimator, Estimator::Quantile { .. });
        if quantile && predict.is_some_and(|asked| asked.kinds.prediction) {
            warnings.push(Warning::NoPredictionOfQuantile);
        }
        let found = predict.map(|asked| predictions(&forms, asked, level));
        (covariance, found.and_then(|found| with_places(found, predict.map_or(0, |asked| asked.at.count()), warnings)))
    }

    pub(super) fn forms_at<'b>(&'b self, applied: &'b Applied, level: f64) -> Forms<'b> {
        let (intervals, regularization) = (applied.posterior_intervals(), &applied.regularization);
        let pooled = applied.pooled().map(|pooled| noise_of(pooled, level));
        // intervals that hold whatever the flank did hold whatever the noise of earlier nodes was
        let noise = match intervals {
            Some(_) => self.noise(level).or(pooled),
            None => pooled.or_else(|| self.noise(level)),
        };
        // the bound on the bias is of filters of least squares whose errors are σ and R
        let plain = self.robust.is_none() && self.errors.is_none();
        Forms {
            linear: self.linear,
            columns: &self.frame.columns,
            spectrum: &self.spectrum,
            map: &applied.map,
            fitted: applied.map.fitted(self.linear, &self.spectrum),
            further: noise.as_ref().and_then(|noise| self.further(applied, noise)),
            sigma: pooled.or(noise).map(|noise| noise.sigma),
            noise,
            posterior: pooled.is_some() || intervals.is_some(),
            posterior_intervals: intervals,
            robust: self.robust.map(|robust| &robust.estimate.spread),
            errors: self.errors,
            given_limit: intervals::given_limit(&applied.bias).filter(|_| plain),
            norm_limit: applied.bias.coefficient_norm_limit,
            chosen_by_heights: depends_on_heights(regularization.criterion),
            conditional: self.is_conditional(applied),
        }
    }

    /// True if standard errors of the estimate treat a λ* selected from the heights as given.
    pub(super) fn is_conditional(&self, applied: &Applied) -> bool {
        let regularization = &applied.regularization;
        depends_on_heights(regularization.criterion)
            && regularization.kind != RegularizationKind::None
            && applied.prior.is_none()
    }

    /// Standard deviation of a further measurement of weight 1, by which its band is as wide as it
    /// is to be at this level: of a robust fit that of its residuals themselves, as far as there
    /// are enough of them, since its dispersion is that of the estimate. None about a quantile.
    fn further(&self, applied: &Applied, noise: &Noise) -> Option<f64> {
        let Some(robust) = self.robust else { return Some(noise.sigma) };
        if matches!(self.spec.estimator, Estimator::Quantile { .. }) {
            return None;
        }
        if self.spec.noise_sigma.is_some() {
            return self.spec.noise_sigma;
        }
        let values = applied.residuals.values.as_deref()?;
        let mut sizes: Vec<f64> = values.iter().enumerate().map(|(k, r)| robust.posted.w(k).sqrt() * r.abs()).collect();
        let (m, freedom) = (sizes.len(), self.degrees_of_freedom);
        let place = ((m + 1) as f64 * (1.0 - noise.miss)).ceil() as usize;
        if freedom == 0 {
            return None;
        }
        let wider = (m as f64 / freedom as f64).sqrt();
        if place > m {
            return Some(wider * (sizes.iter().map(|r| r * r).sum::<f64>() / m as f64).sqrt());
        }
        let (_, size, _) = sizes.select_nth_unstable_by(place - 1, f64::total_cmp);
        Some(wider * *size / noise.quantile())
    }

    /// The coefficients as linear forms, where their errors do not follow from σ and R alone, or a
    /// robust estimate is filtered otherwise than along the eigenvectors.
    pub(super) fn forms_of_coefficients(&self, applied: &Applied) -> Option<Vec<Estimated>> {
        let along = applied.regularization.kind.filters_eigenvectors();
        let robust = self.robust.is_some() && !along && self.degrees_of_freedom > 0;
        if !self.spectrum.full_rank() || !(self.errors.is_some() || robust) {
            return None;
        }
        Some(self.forms_at(applied, self.spec.level).coefficients(&applied.estimate.coefficients))
    }

    /// Confidence intervals of the coefficients: none without an estimate of the noise.
    pub(super) fn intervals(&self, applied: &Applied) -> Vec<Option<Interval>> {
        if applied.pooled().is_some() || applied.posterior_intervals().is_some() {
            return self.posterior_intervals(applied);
        }
        let Some(noise) = self.noise(self.spec.level) else { return Vec::new() };
        let plain = applied.map.is_identity();
        let intervals = Intervals {
            columns: &self.frame.columns,
            spectrum: &self.spectrum,
            noise,
            // the bound on the bias is of filters of least squares
            norm_limit: intervals::given_limit(&applied.bias).filter(|_| self.robust.is_none()),
            unlimited: if plain { IntervalKind::Student } else { IntervalKind::LeastSquares },
        };
        if let Some(own) = self.errors.and_then(|_| self.forms_of_coefficients(applied)) {
            let forms = self.forms_at(applied, self.spec.level);
            let of = |one: &Estimated| {
                let ends = forms.interval(one, 0.0)?;
                let about = forms.inferred(&one.form)?;
                Some(Interval { ends, kind: intervals.unlimited, about, least_squares: None, gain: None })
            };
            return own.iter().map(of).collect();
        }
        if self.errors.is_some() {
            return Vec::new();
        }
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

    /// The interval about the posterior, and that about least squares by the nodes alone.
    fn posterior_intervals(&self, applied: &Applied) -> Vec<Option<Interval>> {
        let alone = self.noise(self.spec.level);
        let forms = self.forms_at(applied, self.spec.level);
        let Some(noise) = &forms.noise else { return Vec::new() };
        let found = forms.coefficients(&applied.estimate.coefficients);
        let of = |(j, one): (usize, &Estimated)| {
            let ends = forms.of_posterior(one, noise, 0.0)?;
            let half = 0.5 * (ends[1] - ends[0]);
            let plain = alone.map(|alone| alone.quantile() * alone.sigma * applied.estimate.leverage[j]);
            let middle = self.least_squares.coefficients[j];
            Some(Interval {
                ends,
                kind: IntervalKind::Posterior,
                about: forms.inferred_posterior(one)?,
                least_squares: plain.map(|plain| [middle - plain, middle + plain]),
                gain: plain.filter(|plain| *plain > 0.0).map(|plain| half / plain),
            })
        };
        found.iter().enumerate().map(of).collect()
    }
}

/// The predictions, unless no place is left; a warning says which are not.
fn with_places(found: Predictions, asked: usize, warnings: &mut Vec<Warning>) -> Option<Predictions> {
    let Some(left) = &found.place_indices else { return Some(found) };
    let mut kept = left.iter().copied().peekable();
    let lost: Vec<usize> = (0..asked).filter(|k| kept.next_if_eq(k).is_none()).collect();
    warnings.push(Warning::PlacesExceedDouble { places: lost.iter().copied().take(10).collect(), count: lost.len() });
    Some(found).filter(|found| !found.value.is_empty())
}

/// The noise by which a posterior was weighed.
fn noise_of(pooled: PooledNoise, level: f64) -> Noise {
    match pooled.freedom {
        None => Noise::known(pooled.sigma, level),
        Some(freedom) => Noise::estimated(pooled.sigma, freedom as f64, level),
    }
}

/// True if λ* depends on the heights.
fn depends_on_heights(chosen_by: Option<ChosenBy>) -> bool {
    !matches!(chosen_by, Some(ChosenBy::Fixed | ChosenBy::Criterion(Criterion::MinCondition)))
}
