//! Everything from the factor on.

use std::sync::Arc;

use super::predict::check;
use crate::{
    data::{Heights, Nodes, Sample},
    diagnostics::{constant_in_span, correct_digits, finite, outliers, perturbation, refuse_dependence},
    enclosure::enclosure,
    error::FitError,
    error_model::spread::ErrorSpread,
    estimate::{Frame, LeastSquares, PlainEstimate},
    problem::{Evidence, LinearProblem},
    regularized::{Applied, Context, apply, regularized_spectrum},
    result::{
        Coefficient, Enclosure, FitResult, NotEnclosed, Numerics, PerturbationReport, RegularizedSpectrum,
        ResidualReport, RobustReport, SpectrumReport, Warning,
    },
    robust::{RobustEstimate, RobustSolution},
    spec::{FitSpec, Include, Scaling},
    spectrum::{ScaledColumns, Spectrum},
};
use flankfit_numerics::Dd;

/// Concludes a robust fit as the least-squares problem that it solves, with plain least squares
/// next to it; `linear` and `frame` are of the posted nodes.
pub(super) fn conclude_robust(
    linear: &LinearProblem,
    sample: &Sample,
    nodes: &Nodes,
    heights: &Heights,
    spec: &FitSpec,
    frame: &Frame,
    robust: &RobustEstimate,
) -> Result<FitResult, FitError> {
    let plain = PlainEstimate::new(linear, frame);
    let reweighted = robust.weights.as_deref().map(|weights| sample.reweighted(weights));
    let weight = reweighted.as_ref().map_or(heights.weight, |sample| Heights::new(sample).weight);
    let evidence = Evidence::Posted { sample: reweighted.as_ref().unwrap_or(sample), nodes };
    let frame = Frame::new(linear.design, &robust.factor, spec, weight)?;
    let robust = RobustSolution { estimate: robust, plain, posted: sample, problem: linear, weight };
    conclude(
        &LinearProblem { factor: &robust.estimate.factor, evidence, ..*linear },
        heights,
        spec,
        &frame,
        Some(&robust),
    )
}

/// Everything from the factor on. What needs the nodes themselves asks `linear`; where they are
/// gone (a stream keeps sums only) such figures are left out.
pub(crate) fn report(linear: &LinearProblem, heights: &Heights, spec: &FitSpec) -> Result<FitResult, FitError> {
    let frame = Frame::new(linear.design, linear.factor, spec, heights.weight)?;
    conclude(linear, heights, spec, &frame, None)
}

/// Computes the coordinates of the heights along the directions of the columns, and everything that
/// follows: λ*, estimate, bounds. For a robust estimate `linear` holds the problem that it solves,
/// `heights` are those of the posted nodes.
pub(super) fn conclude(
    linear: &LinearProblem,
    heights: &Heights,
    spec: &FitSpec,
    frame: &Frame,
    robust: Option<&RobustSolution>,
) -> Result<FitResult, FitError> {
    conclude_with(linear, heights, spec, frame, robust, None)
}

/// The same with covariances that do not follow from σ and R alone.
pub(super) fn conclude_with(
    linear: &LinearProblem,
    heights: &Heights,
    spec: &FitSpec,
    frame: &Frame,
    robust: Option<&RobustSolution>,
    errors: Option<&ErrorSpread>,
) -> Result<FitResult, FitError> {
    check(linear.design, spec)?;
    let mut warnings = robust.map_or_else(Vec::new, |robust| robust.estimate.warnings.clone());
    let solved = Solved { errors, ..Solved::new(linear, heights, spec, frame, robust, &mut warnings)? };
    warnings.extend(solved.outliers());
    warnings.extend(solved.residual_checks());
    let mut applied = solved.regularized(&mut warnings)?;
    solved.norm_limit(&mut applied, &mut warnings);
    if spec.include.predicted_mse && applied.regularization.predicted_mse_corrected.is_none() {
        warnings.push(Warning::NothingToCorrect);
    }
    warnings.extend(frame.warnings.iter().cloned());
    let regularized = std::mem::take(&mut applied.spectrum);
    let spectrum = spectrum_report(&solved.spectrum, &frame.columns, regularized);
    let perturbation = solved.perturbation(spectrum.condition, applied.after.take(), &mut warnings);
    let correct_digits = solved.correct_digits(&applied, &mut warnings);
    let (covariance, predictions) = solved.forms(&applied, &mut warnings);
    let sums = solved.sums(&applied);
    let influence = solved.influence(&applied, &mut warnings);
    let shape = solved.shape(&applied, &mut warnings);
    let estimable = solved.estimable(&applied);
    let enclosure = solved.enclosure(&mut warnings);
    let values = applied.residuals.values.take();
    let result = FitResult {
        coefficients: solved.coefficients(&applied),
        domain: linear.design.domain,
        spectrum,
        collinearity: Arc::clone(&frame.collinearity),
        perturbation,
        residuals: solved.residuals(&applied, values),
        robust: robust.map(|robust| {
            let report = robust.estimate.report.clone();
            let included = spec.include.robust_weights;
            RobustReport {
                coefficients: solved.least_squares.coefficients.clone(),
                weights: report.weights.filter(|_| included),
                rejected: report.rejected.filter(|_| included),
                ..report
            }
        }),
        regularization: applied.regularization,
        bias: applied.bias,
        filters: None,
        filter_collinearity: None,
        prior: applied.prior.map(|prior| prior.report),
        constraints: applied.constraints,
        covariance,
        predictions,
        sums,
        influence,
        selection: None,
        shape,
        errors: None,
        variance: None,
        positions: None,
        without_suspected: None,
        lambda_curve: applied.curve,
        ridge_trace: applied.trace,
        matrix_b: applied.matrix_b,
        matrix_b_factors: applied.matrix_b_factors,
        representative: applied.representative,
        estimable,
        numerics: Numerics { arithmetic: linear.factor.arithmetic, correct_digits, enclosure },
        warnings,
    };
    finite::checked(result)
}

/// The least-squares problem along the directions of its columns, before it is regularised.
pub(super) struct Solved<'a> {
    pub(super) linear: &'a LinearProblem<'a>,
    pub(super) heights: &'a Heights,
    pub(super) spec: &'a FitSpec,
    pub(super) frame: &'a Frame,
    pub(super) robust: Option<&'a RobustSolution<'a>>,
    pub(super) errors: Option<&'a ErrorSpread>,
    /// Σw of the problem that is solved.
    pub(super) weight: f64,
    pub(super) spectrum: Spectrum,
    pub(super) least_squares: LeastSquares,
    pub(super) degrees_of_freedom: usize,
    /// `Σ w r²` of plain least squares, and the σ̂ that follows from it.
    pub(super) least_squares_rss: f64,
    pub(super) sigma: Option<f64>,
    /// σ of a height of weight 1 in the problem that is solved.
    pub(super) noise: Option<f64>,
}

impl<'a> Solved<'a> {
    /// Spectrum, least squares and noise; dependent columns are named or refused.
    fn new(
        linear: &'a LinearProblem<'a>,
        heights: &'a Heights,
        spec: &'a FitSpec,
        frame: &'a Frame,
        robust: Option<&'a RobustSolution<'a>>,
        warnings: &mut Vec<Warning>,
    ) -> Result<Self, FitError> {
        let (design, factor) = (linear.design, linear.factor);
        let Frame { caller, columns, unit, .. } = frame;
        let level = columns.constant.as_ref().map_or(Dd::ZERO, |constant| constant.level(caller, &factor.qty));
        let spectrum = Spectrum::new(frame.directions.clone(), &factor.qty, level);
        if !spectrum.full_rank() {
            // names must not depend on how the columns are scaled
            match (unit, spec.scaling) {
                (Some((columns, unit)), Scaling::None) => refuse_dependence(design, columns, unit, spec, warnings)?,
                _ => refuse_dependence(design, columns, &spectrum, spec, warnings)?,
            }
        }
        let least_squares = LeastSquares::new(linear, columns, &spectrum);
        let free = spectrum.rank + usize::from(columns.constant.is_some());
        let degrees_of_freedom = linear.evidence.count() - free;
        let least_squares_rss = robust.map_or(least_squares.rss, |robust| robust.plain.rss);
        let sigma = (degrees_of_freedom > 0).then(|| (least_squares_rss / degrees_of_freedom as f64).sqrt());
        let noise = robust.map_or(sigma, |robust| robust.estimate.sigma.filter(|_| degrees_of_freedom > 0));
        if sigma.is_none() && (spec.noise_sigma.is_none() || robust.is_some()) {
            warnings.push(Warning::NoDegreesOfFreedom);
        }
        let weight = robust.map_or(heights.weight, |robust| robust.weight);
        Ok(Solved {
            linear,
            heights,
            spec,
            frame,
            robust,
            errors: None,
            weight,
            spectrum,
            least_squares,
            degrees_of_freedom,
            least_squares_rss,
            sigma,
            noise,
        })
    }

    /// Returns the nodes suspected of gross errors. Robust estimates need no test; with correlated
    /// errors the posted heights are tested, not the whitened ones.
    fn outliers(&self) -> Option<Warning> {
        let white = matches!(self.linear.evidence, Evidence::Posted { sample, .. } if sample.is_white());
        if self.robust.is_some() || white || !self.spectrum.full_rank() {
            return None;
        }
        outliers(self.linear, self.heights.largest).map(Warning::OutliersSuspected)
    }

    /// Applies the requested regularisation.
    fn regularized(&self, warnings: &mut Vec<Warning>) -> Result<Applied, FitError> {
        let Solved { spec, linear, .. } = *self;
        // residuals of robust estimates are always looked at: their sums are reported with the
        // posted weights; influences are made of them
        let with_residuals = (self.robust.is_some() || spec.include.influence)
            .then(|| FitSpec { include: Include { residuals: true, ..spec.include }, ..spec.clone() });
        let context = Context {
            spec: with_residuals.as_ref().unwrap_or(spec),
            linear,
            columns: &self.frame.columns,
            spectrum: &self.spectrum,
            least_squares: &self.least_squares,
            weight: self.weight,
            degrees_of_freedom: self.degrees_of_freedom,
            variance: spec.noise_sigma.or(self.noise).map(|s| s * s),
        };
        let mut applied = apply(&context, warnings)?;
        if let (Some(robust), Some(values)) = (self.robust, &applied.residuals.values) {
            let (rss, max_abs) = robust.sums(values);
            (applied.rss, applied.residuals.max_abs) = (rss, Some(max_abs));
        }
        Ok(applied)
    }

    /// Perturbation bounds, where the uncertainty of the nodes is known; `after` is the regularised
    /// estimate.
    fn perturbation(
        &self,
        condition: Option<f64>,
        after: Option<perturbation::Estimate>,
        warnings: &mut Vec<Warning>,
    ) -> Option<PerturbationReport> {
        let uncertainty = self.spec.node_uncertainty?;
        if uncertainty.position > 0.0 && uncertainty.kind.is_none() {
            warnings.push(Warning::PositionsAsExact);
        }
        let bounded = after.is_some();
        let before = perturbation::Estimate {
            condition,
            largest: self.spectrum.largest(),
            norm: self.spectrum.a.iter().map(|a| a * a).sum::<f64>().sqrt(),
        };
        let after = after.unwrap_or_else(|| {
            warnings.push(Warning::NoRegularizedPerturbation);
            perturbation::Estimate { condition: None, largest: 0.0, norm: 0.0 }
        });
        let vanishing = before.norm == 0.0 || (bounded && after.norm == 0.0);
        let slopes = self.linear.evidence.slopes(self.linear.design, &self.frame.columns);
        let length = self.heights.about_zero.sqrt();
        let estimates = [before, after];
        let report = perturbation::report(slopes, self.weight, uncertainty, length, self.least_squares.rss, estimates);
        let unbounded =
            report.least_squares.square_bound.is_none() || (bounded && report.regularized.square_bound.is_none());
        if vanishing {
            warnings.push(Warning::NoRelativeError);
        } else if unbounded {
            warnings.push(Warning::PerturbationUnbounded);
        }
        Some(report)
    }

    /// Digits of the worst coefficient that the posted numbers, rounded to doubles, determine.
    fn correct_digits(&self, applied: &Applied, warnings: &mut Vec<Warning>) -> f64 {
        // where columns depend on each other the nodes do not determine the coefficients at all,
        // and a warning said so
        if !self.spectrum.full_rank() {
            return 0.0;
        }
        let (linear, least_squares) = (self.linear, &self.least_squares);
        let digits = correct_digits::correct_digits(&correct_digits::Fitted {
            design: linear.design,
            evidence: linear.evidence,
            largest_height: self.heights.largest,
            r: &linear.factor.r,
            axes: linear.factor.separable.as_ref().map(|separable| [&separable.axes.u.r, &separable.axes.v.r]),
            working: &least_squares.working,
            coefficients: &least_squares.coefficients,
            leverage: &applied.estimate.leverage,
            sensitivity: &applied.estimate.sensitivity,
            sigma: self.noise,
            // without the nodes √rss is all that is known of the largest residual
            max_residual: least_squares.max_abs.unwrap_or_else(|| least_squares.rss.sqrt()),
            relative_error: linear.factor.relative_error,
            length: self.heights.about_zero.sqrt(),
        });
        if digits < 6.0 {
            warnings.push(Warning::FewDigits { digits });
        }
        digits
    }

    /// Proved intervals of the least-squares results, if they were included.
    fn enclosure(&self, warnings: &mut Vec<Warning>) -> Option<Enclosure> {
        if !self.spec.include.enclosure {
            return None;
        }
        let found = match (self.robust, self.errors) {
            (None, None) => enclosure(self.linear, self.heights, self.spec.noise_sigma, self.degrees_of_freedom),
            _ => Err(NotEnclosed::OtherFit),
        };
        found.map_err(|reason| warnings.push(Warning::NoEnclosure { reason })).ok()
    }

    fn coefficients(&self, applied: &Applied) -> Vec<Coefficient> {
        let design = self.linear.design;
        let mut intervals = self.intervals(applied).into_iter();
        let alone = self.spec.noise_sigma.or(self.sigma);
        let sigma = applied.pooled().map_or(alone, |pooled| Some(pooled.sigma));
        let own = self.forms_of_coefficients(applied);
        let (plain, leverage) = match self.robust {
            Some(RobustSolution { plain, .. }) => (&plain.coefficients, &plain.leverage),
            None => (&self.least_squares.coefficients, &applied.estimate.leverage),
        };
        let (spectrum, columns, factor) = (&self.spectrum, &self.frame.columns, self.linear.factor);
        let freedom = self.degrees_of_freedom > 0;
        let robust_errors = self.robust.map(|robust| {
            let (estimate, regularization) = (&applied.estimate, &applied.regularization);
            robust.estimate.spread.standard_errors(estimate, spectrum, columns, factor, regularization)
        });
        let conditional = self.is_conditional(applied);
        let unregularized = self
            .robust
            .filter(|_| conditional)
            .map(|robust| robust.estimate.spread.of_unregularized(design.size(), spectrum, columns, factor));
        (0..design.size())
            .map(|j| {
                let for_lambda = match (&own, &robust_errors) {
                    (Some(own), _) => own[j].conditional_error,
                    (None, Some(errors)) => errors[j].filter(|_| freedom),
                    (None, None) if self.errors.is_some() => None,
                    (None, None) => sigma.map(|s| s * applied.estimate.spread[j]),
                };
                let least_squares_std_error = match &own {
                    Some(own) if self.errors.is_some() => own[j].least_squares_error,
                    _ if self.errors.is_some() => None,
                    _ => alone.map(|s| s * leverage[j]),
                };
                let without = match &unregularized {
                    Some(errors) => errors[j].filter(|_| freedom),
                    None => least_squares_std_error,
                };
                Coefficient {
                    term: design.labels[j].clone(),
                    key: design.keys[j].clone(),
                    value: applied.estimate.coefficients[j],
                    std_error: if conditional { without } else { for_lambda },
                    conditional_std_error: for_lambda.filter(|_| conditional && for_lambda != without),
                    least_squares: plain[j],
                    least_squares_std_error,
                    bias_bound: applied.bounds[j],
                    interval: intervals.next().flatten(),
                }
            })
            .collect()
    }

    fn residuals(&self, applied: &Applied, values: Option<Vec<f64>>) -> ResidualReport {
        let Solved { linear, heights, .. } = *self;
        let columns = &self.frame.columns;
        let spans = constant_in_span(linear.design, linear.factor, columns, &self.spectrum, self.weight);
        let total = if spans { heights.about_mean } else { heights.about_zero };
        let wanted = self.spec.include.residuals;
        let counted = || linear.evidence.counted().map(|index| index.iter().map(|&k| k as usize).collect());
        ResidualReport {
            count: linear.evidence.count(),
            degrees_of_freedom: self.degrees_of_freedom,
            rss: applied.rss,
            sigma: self.sigma,
            rms: (applied.rss / heights.weight).sqrt(),
            max_abs: applied.residuals.max_abs,
            r_squared: (total > 0.0).then(|| 1.0 - applied.rss / total),
            least_squares_rss: self.least_squares_rss,
            node_indices: wanted.then(counted).flatten(),
            fitted: None,
            heights: None,
            values: values.filter(|_| wanted),
        }
    }
}

/// The eigenvalues of the scaled columns, and what became of them.
fn spectrum_report(spectrum: &Spectrum, columns: &ScaledColumns, regularized: RegularizedSpectrum) -> SpectrumReport {
    let plain = regularized_spectrum(spectrum.lambda.clone());
    SpectrumReport {
        condition: plain.condition,
        log10_condition: plain.condition.map(f64::log10),
        log10_determinant: plain.log10_determinant,
        rank: spectrum.rank + usize::from(columns.constant.is_some()),
        eigenvalues: plain.eigenvalues,
        regularized,
    }
}
