//! Everything from the factor on.

use std::sync::Arc;

use crate::{
    estimation::{
        data::{Heights, Nodes, Sample},
        diagnostics::{constant_in_span, correct_digits, finite, perturbation, refuse_dependence},
        error::FitError,
        estimate::{Beside, Frame, LeastSquares},
        problem::{Evidence, Place},
        regularized::{Context, apply, regularized_spectrum},
        result::{
            Coefficient, FitResult, Numerics, RegularizedSpectrum, ResidualReport, RobustReport, SpectrumReport,
            Warning,
        },
        robust::{Joined, Robust},
        spec::{FitSpec, Include, Scaling},
        spectrum::{ScaledColumns, Spectrum},
    },
    numerics::Dd,
};

/// A robust estimate goes on as the least-squares problem that it solves, plain least squares
/// beside it; `place` and `frame` are of the posted nodes.
pub fn conclude_robust(
    place: &Place,
    sample: &Sample,
    nodes: &Nodes,
    heights: &Heights,
    spec: &FitSpec,
    frame: &Frame,
    robust: &Robust,
) -> Result<FitResult, FitError> {
    let beside = Beside::new(place, frame);
    let reweighted = robust.weights.as_deref().map(|weights| sample.reweighted(weights));
    let weight = reweighted.as_ref().map_or(heights.weight, |sample| Heights::new(sample).weight);
    let evidence = Evidence::Posted { sample: reweighted.as_ref().unwrap_or(sample), nodes };
    let frame = Frame::new(place.design, &robust.factor, spec, weight)?;
    let joined = Joined { robust, beside, posted: sample, weight };
    conclude(&Place { factor: &robust.factor, evidence, ..*place }, heights, spec, &frame, Some(&joined))
}

/// Everything from the factor on. What needs the nodes themselves asks `place`; where they are gone
/// (a stream keeps sums only) such figures are left out.
pub fn report(place: &Place, heights: &Heights, spec: &FitSpec) -> Result<FitResult, FitError> {
    let frame = Frame::new(place.design, place.factor, spec, heights.weight)?;
    conclude(place, heights, spec, &frame, None)
}

/// What the heights have along the directions of the columns, and everything that follows: λ*,
/// estimate, bounds. For a robust estimate `place` holds the problem that it solves, `heights` are
/// those of the posted nodes.
pub fn conclude(
    place: &Place,
    heights: &Heights,
    spec: &FitSpec,
    frame: &Frame,
    joined: Option<&Joined>,
) -> Result<FitResult, FitError> {
    let (design, factor) = (place.design, place.factor);
    let Frame { caller, columns, unit, .. } = frame;
    let count = place.evidence.count();
    let weight = joined.map_or(heights.weight, |joined| joined.weight);
    let mut warnings = joined.map_or_else(Vec::new, |joined| joined.robust.warnings.clone());
    let level = columns.constant.as_ref().map_or(Dd::ZERO, |constant| constant.level(caller, &factor.qty));
    let spectrum = Spectrum::new(frame.directions.clone(), &factor.qty, level);
    if !spectrum.full_rank() {
        // names must not depend on how the columns are scaled
        match (unit, spec.scaling) {
            (Some((columns, unit)), Scaling::None) => refuse_dependence(design, columns, unit, spec, &mut warnings)?,
            _ => refuse_dependence(design, columns, &spectrum, spec, &mut warnings)?,
        }
    }
    let least_squares = LeastSquares::new(place, columns, &spectrum);
    let free = spectrum.rank + usize::from(columns.constant.is_some());
    let degrees_of_freedom = count - free;
    let least_squares_rss = joined.map_or(least_squares.rss, |joined| joined.beside.rss);
    let sigma = (degrees_of_freedom > 0).then(|| (least_squares_rss / degrees_of_freedom as f64).sqrt());
    let noise = joined.map_or(sigma, |joined| joined.robust.sigma.filter(|_| degrees_of_freedom > 0));
    if sigma.is_none() {
        warnings.push(Warning {
            code: "no_degrees_of_freedom",
            message: "as many coefficients as nodes: there is no estimate of the noise, so no standard errors".into(),
        });
    }
    // residuals of robust estimates are always looked at: their sums are reported with the posted
    // weights
    let looking = joined.map(|_| FitSpec { include: Include { residuals: true, ..spec.include }, ..spec.clone() });
    let mut applied = apply(
        &Context {
            spec: looking.as_ref().unwrap_or(spec),
            place,
            columns,
            spectrum: &spectrum,
            least_squares: &least_squares,
            weight,
            degrees_of_freedom,
            variance: spec.noise_sigma.or(noise).map(|s| s * s),
        },
        &mut warnings,
    )?;
    if let (Some(joined), Some(values)) = (joined, &applied.residuals.values) {
        let (rss, max_abs) = joined.sums(values);
        (applied.rss, applied.residuals.max_abs) = (rss, Some(max_abs));
    }
    warnings.extend(frame.warnings.iter().cloned());
    let spectrum_report = spectrum_report(&spectrum, columns, applied.spectrum);
    let bounded = applied.after.is_some();
    let mut vanishing = false;
    let perturbation = spec.node_uncertainty.map(|uncertainty| {
        let before = perturbation::Estimate {
            condition: spectrum_report.condition,
            largest: spectrum.largest(),
            norm: spectrum.a.iter().map(|a| a * a).sum::<f64>().sqrt(),
        };
        let after = applied.after.unwrap_or_else(|| {
            warnings.push(Warning {
                code: "no_regularized_perturbation",
                message:
                    "perturbation bounds are those of one matrix X + B; this estimate is not made by one, so only \
                          least squares has them"
                        .into(),
            });
            perturbation::Estimate { condition: None, largest: 0.0, norm: 0.0 }
        });
        vanishing = before.norm == 0.0 || (bounded && after.norm == 0.0);
        let rss = least_squares.rss;
        let slopes = place.evidence.slopes(design, columns);
        perturbation::report(slopes, weight, uncertainty, heights.about_zero.sqrt(), rss, [before, after])
    });
    if vanishing {
        warnings.push(Warning {
            code: "no_relative_error",
            message:
                "the coefficients are all 0: bounds on their relative error divide by their length, so there are none"
                    .into(),
        });
    } else if let Some(p) = &perturbation
        && (p.least_squares.square_bound.is_none() || (bounded && p.regularized.square_bound.is_none()))
    {
        warnings.push(Warning {
            code: "perturbation_unbounded",
            message: "the node uncertainty times the condition reaches 1: the square bound does not exist there".into(),
        });
    }
    let total = if constant_in_span(design, factor, columns, &spectrum, weight) {
        heights.about_mean
    } else {
        heights.about_zero
    };
    let correct_digits = correct_digits::correct_digits(&correct_digits::Fitted {
        design,
        evidence: place.evidence,
        largest_height: heights.largest,
        r: &factor.r,
        working: &least_squares.working,
        coefficients: &least_squares.coefficients,
        leverage: &applied.estimate.leverage,
        sensitivity: &applied.estimate.sensitivity,
        sigma: noise,
        // without the nodes √rss is all that is known of the largest residual
        max_residual: least_squares.max_abs.unwrap_or_else(|| least_squares.rss.sqrt()),
        relative_error: factor.relative_error,
        length: heights.about_zero.sqrt(),
    });
    // where columns depend on each other the nodes do not determine the coefficients at all, and a
    // warning said so
    let correct_digits = if spectrum.full_rank() { correct_digits } else { 0.0 };
    if correct_digits < 6.0 && spectrum.full_rank() {
        warnings.push(Warning {
            code: "few_digits",
            message: format!(
                "the posted numbers, rounded to doubles, determine the worst coefficient to about {correct_digits:.0} \
                 digits only"
            ),
        });
    }
    let (plain_coefficients, plain_leverage) = match joined {
        Some(Joined { beside, .. }) => (&beside.coefficients, &beside.leverage),
        None => (&least_squares.coefficients, &applied.estimate.leverage),
    };
    let standard_errors = joined.map(|joined| {
        joined.robust.spread.standard_errors(&applied.estimate, &spectrum, columns, factor, &applied.regularization)
    });
    let coefficients = (0..design.size())
        .map(|j| Coefficient {
            term: design.labels[j].clone(),
            key: design.keys[j].clone(),
            value: applied.estimate.coefficients[j],
            std_error: match &standard_errors {
                Some(errors) => errors[j].filter(|_| degrees_of_freedom > 0),
                None => sigma.map(|s| s * applied.estimate.spread[j]),
            },
            least_squares: plain_coefficients[j],
            least_squares_std_error: sigma.map(|s| s * plain_leverage[j]),
            bias_bound: applied.bounds[j],
        })
        .collect();
    let result = FitResult {
        coefficients,
        domain: design.domain,
        spectrum: spectrum_report,
        regularization: applied.regularization,
        bias: applied.bias,
        collinearity: Arc::clone(&frame.collinearity),
        perturbation,
        residuals: ResidualReport {
            count,
            degrees_of_freedom,
            rss: applied.rss,
            sigma,
            rms: (applied.rss / heights.weight).sqrt(),
            max_abs: applied.residuals.max_abs,
            r_squared: (total > 0.0).then(|| 1.0 - applied.rss / total),
            least_squares_rss,
            node_indices: spec
                .include
                .residuals
                .then(|| place.evidence.counted().map(|index| index.iter().map(|&k| k as usize).collect()))
                .flatten(),
            values: applied.residuals.values.filter(|_| spec.include.residuals),
        },
        robust: joined.map(|joined| RobustReport {
            coefficients: least_squares.coefficients.clone(),
            ..joined.robust.report.clone()
        }),
        filtering: None,
        lambda_curve: applied.curve,
        ridge_trace: applied.trace,
        matrix_b: applied.matrix_b,
        numerics: Numerics { arithmetic: factor.arithmetic, correct_digits },
        warnings,
    };
    finite::checked(result)
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
