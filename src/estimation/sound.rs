//! The last look at an answer: no number in it is infinite or NaN.
//!
//! A figure that may be absent is left out, with a warning; one that an answer cannot do without refuses the fit.

use super::{
    error::{Faults, FitError},
    result::{FitResult, Warning},
};

/// Leaves out what is not finite, or refuses.
pub fn checked(mut result: FitResult) -> Result<FitResult, FitError> {
    let mut dropped: Vec<&'static str> = Vec::new();
    let mut optional = |name: &'static str, value: &mut Option<f64>| {
        if value.is_some_and(|x| !x.is_finite()) {
            *value = None;
            if !dropped.contains(&name) {
                dropped.push(name);
            }
        }
    };
    for c in &mut result.coefficients {
        optional("std_error", &mut c.std_error);
        optional("least_squares_std_error", &mut c.least_squares_std_error);
    }
    for column in &mut result.collinearity.columns {
        optional("vif", &mut column.vif);
    }
    for near in &mut result.collinearity.near_dependencies {
        optional("condition_index", &mut near.condition_index);
        optional("cosine", &mut near.cosine);
        optional("weight_ratio", &mut near.weight_ratio);
        optional("r_squared", &mut near.r_squared);
    }
    for choice in &mut result.regularization.choices {
        optional("choices.condition", &mut choice.condition);
        optional("choices.predicted_mse", &mut choice.predicted_mse);
        optional("choices.lambda_star", &mut choice.lambda_star);
    }
    for point in result.lambda_curve.iter_mut().flatten() {
        optional("lambda_curve.condition", &mut point.condition);
        optional("lambda_curve.predicted_mse", &mut point.predicted_mse);
        optional("lambda_curve.gcv", &mut point.gcv);
    }
    if let Some(points) = &mut result.lambda_curve {
        points.retain(|p| [p.lambda_star, p.bias_norm, p.rms, p.coefficient_norm].into_iter().all(f64::is_finite));
    }
    let regularization = &mut result.regularization;
    optional("lambda_star", &mut regularization.lambda_star);
    optional("gamma", &mut regularization.gamma);
    optional("matrix_norm_squared", &mut regularization.matrix_norm_squared);
    optional("largest_eigenvalue_bound", &mut regularization.largest_eigenvalue_bound);
    optional("paper_bound", &mut result.bias.paper_bound);
    optional("e", &mut result.bias.e);
    optional("sigma", &mut result.residuals.sigma);
    optional("r_squared", &mut result.residuals.r_squared);
    if regularization.lambda_star_interval.is_some_and(|ends| !ends.into_iter().all(f64::is_finite)) {
        regularization.lambda_star_interval = None;
    }
    if !dropped.is_empty() {
        result.warnings.push(Warning {
            code: "beyond_double",
            message: format!("left out because they leave the range of double precision: {}", dropped.join(", ")),
        });
    }
    let all = |values: &[f64]| values.iter().all(|x| x.is_finite());
    if !all(&result.spectrum.regularized.eigenvalues) {
        return Err(
            Faults::one("/regularization", "λ* lifts an eigenvalue beyond the range of double precision").into()
        );
    }
    let residuals = &result.residuals;
    let sound = result.coefficients.iter().all(|c| all(&[c.value, c.least_squares, c.bias_bound]))
        && all(&result.spectrum.eigenvalues)
        && all(&result.regularization.filter_factors)
        && result.regularization.choices.iter().all(|c| all(&[c.bias_norm, c.rms]))
        && all(&[result.bias.norm, result.bias.sharp_bound, result.bias.coefficient_norm_limit])
        && all(&[residuals.rss, residuals.rms, residuals.least_squares_rss])
        && residuals.max_abs.is_none_or(f64::is_finite)
        && residuals.values.as_deref().is_none_or(all)
        && result.matrix_b.iter().flatten().all(|row| all(row))
        && result.collinearity.correlation.iter().flatten().all(|row| all(row))
        && result.collinearity.variance_proportions.iter().flatten().all(|row| all(row))
        && result.collinearity.near_dependencies.iter().all(|near| near.eigenvalue.is_finite() && all(&near.weights));
    if sound {
        return Ok(result);
    }
    Err(Faults::one("/nodes", "figures of this fit leave the range of double precision: choose another unit or basis")
        .into())
}
