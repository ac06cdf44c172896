//! The last look at an answer: no number in it is infinite or NaN.
//!
//! A figure that may be absent is left out, with a warning; one that an answer cannot do without
//! refuses the fit.

use crate::{
    error::FitError,
    result::{
        CollinearityReport, ConstraintsReport, Covariance, ErrorsReport, EstimableSum, FilterCollinearity,
        FilterReport, FitResult, Influence, Interval, LikelihoodReport, MatrixBFactors, MinimaxReport, PositionsReport,
        Predictions, PriorReport, Selection, VarianceReport, Warning,
    },
};
use flankfit_numerics::check::Faults;

/// Names of figures that were left out.
#[derive(Default)]
struct Dropped(Vec<&'static str>);

impl Dropped {
    fn look_at(&mut self, name: &'static str, value: &mut Option<f64>) {
        self.unless(name, value, |x| x.is_finite());
    }

    fn unless<T>(&mut self, name: &'static str, value: &mut Option<T>, sound: impl Fn(&T) -> bool) {
        if value.as_ref().is_some_and(|x| !sound(x)) {
            *value = None;
            if !self.0.contains(&name) {
                self.0.push(name);
            }
        }
    }

    fn warn(self, warnings: &mut Vec<Warning>) {
        if !self.0.is_empty() {
            warnings.push(Warning::ExceedsDouble { figures: self.0 });
        }
    }
}

/// Error for a fit whose results exceed double precision.
pub fn exceeds_double() -> FitError {
    let message = "results of this fit exceed the range of double precision: choose another unit or basis";
    FitError::ExceedsDouble(Faults::one("nodes", message))
}

fn all(values: &[f64]) -> bool {
    values.iter().all(|x| x.is_finite())
}

/// The same for a collinearity report.
pub fn checked_collinearity(
    mut report: CollinearityReport,
    warnings: &mut Vec<Warning>,
) -> Result<CollinearityReport, FitError> {
    let mut dropped = Dropped::default();
    for column in &mut report.columns {
        dropped.look_at("vif", &mut column.vif);
    }
    if let Some(basis) = &mut report.basis {
        dropped.look_at("basis.condition", &mut basis.condition);
    }
    for near in &mut report.near_dependencies {
        dropped.look_at("condition_index", &mut near.condition_index);
        dropped.look_at("cosine", &mut near.cosine);
        dropped.look_at("weight_ratio", &mut near.weight_ratio);
        dropped.look_at("r_squared", &mut near.r_squared);
    }
    dropped.warn(warnings);
    let sound = report.correlation.iter().flatten().all(|row| all(row))
        && report.variance_proportions.iter().flatten().all(|row| all(row))
        && report
            .near_dependencies
            .iter()
            .all(|near| near.eigenvalue.is_finite() && near.weights.iter().all(|weights| all(weights)));
    if sound { Ok(report) } else { Err(exceeds_double()) }
}

/// The same for what filters did.
pub fn checked_filtering(
    filters: Vec<FilterReport>,
    mut columns: FilterCollinearity,
    warnings: &mut Vec<Warning>,
) -> Result<(Vec<FilterReport>, FilterCollinearity), FitError> {
    let mut dropped = Dropped::default();
    for figures in [&mut columns.before, &mut columns.after] {
        dropped.look_at("filter_collinearity.condition", &mut figures.condition);
        dropped.look_at("filter_collinearity.largest_correlation", &mut figures.largest_correlation);
        dropped.look_at("filter_collinearity.largest_vif", &mut figures.largest_vif);
    }
    dropped.warn(warnings);
    let sound = filters.iter().all(|filter| all(&[filter.max_change, filter.rms_change]));
    if sound { Ok((filters, columns)) } else { Err(exceeds_double()) }
}

/// Parts that are included only on request.
fn look_at_parts(result: &mut FitResult, dropped: &mut Dropped) {
    dropped.unless("constraints", &mut result.constraints, ConstraintsReport::is_finite);
    dropped.unless("representative", &mut result.representative, |piece| {
        let ranges = piece.domain.iter().flat_map(|domain| [domain.u, domain.v]).flatten().flatten();
        let lists = piece.directions.iter().chain([&piece.eigenvalues, &piece.scale]).flatten().copied();
        lists.chain(ranges).chain([piece.lambda_star]).all(f64::is_finite)
    });
    dropped.unless("regularization.representative", &mut result.regularization.representative, |piece| {
        piece.alignment.is_finite()
    });
    dropped.unless("estimable", &mut result.estimable, |sums| sums.iter().all(EstimableSum::is_finite));
    dropped.unless("matrix_b_factors", &mut result.matrix_b_factors, MatrixBFactors::is_finite);
    dropped.unless("prior", &mut result.prior, PriorReport::is_finite);
    dropped.unless("errors", &mut result.errors, ErrorsReport::is_finite);
    dropped.unless("variance", &mut result.variance, VarianceReport::is_finite);
    dropped.unless("positions", &mut result.positions, PositionsReport::is_finite);
    dropped.unless("covariance", &mut result.covariance, Covariance::is_finite);
    dropped.unless("predictions", &mut result.predictions, Predictions::is_finite);
    dropped.unless("selection", &mut result.selection, Selection::is_finite);
    dropped.unless("influence", &mut result.influence, Influence::is_finite);
}

/// Leaves out what is not finite, or refuses.
pub fn checked(mut result: FitResult) -> Result<FitResult, FitError> {
    let mut dropped = Dropped::default();
    let mut optional = |name: &'static str, value: &mut Option<f64>| dropped.look_at(name, value);
    let spectrum = &mut result.spectrum;
    optional("condition", &mut spectrum.condition);
    optional("log10_condition", &mut spectrum.log10_condition);
    optional("log10_determinant", &mut spectrum.log10_determinant);
    optional("regularized.condition", &mut spectrum.regularized.condition);
    optional("regularized.log10_determinant", &mut spectrum.regularized.log10_determinant);
    for bounds in result.perturbation.iter_mut().flat_map(|p| [&mut p.least_squares, &mut p.regularized]) {
        optional("square_bound", &mut bounds.square_bound);
        optional("first_order_bound", &mut bounds.first_order_bound);
    }
    for c in &mut result.coefficients {
        optional("std_error", &mut c.std_error);
        optional("conditional_std_error", &mut c.conditional_std_error);
        optional("least_squares_std_error", &mut c.least_squares_std_error);
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
    optional("shrinkage_factor", &mut regularization.shrinkage_factor);
    optional("gamma", &mut regularization.gamma);
    optional("matrix_norm_squared", &mut regularization.matrix_norm_squared);
    optional("largest_eigenvalue_bound", &mut regularization.largest_eigenvalue_bound);
    optional("predicted_mse_corrected", &mut regularization.predicted_mse_corrected);
    optional("paper_bound", &mut result.bias.paper_bound);
    optional("e", &mut result.bias.e);
    optional("upper_confidence", &mut result.bias.upper_confidence);
    optional("sigma", &mut result.residuals.sigma);
    optional("r_squared", &mut result.residuals.r_squared);
    if let Some(robust) = &mut result.robust {
        optional("robust.tolerance_reached", &mut robust.tolerance_reached);
        optional("robust.dispersion", &mut robust.dispersion);
        optional("robust.certificate", &mut robust.certificate);
    }
    if regularization.lambda_star_interval.is_some_and(|ends| !ends.into_iter().all(f64::is_finite)) {
        regularization.lambda_star_interval = None;
    }
    if let Some(robust) = &mut result.robust {
        dropped.unless("robust.minimax", &mut robust.minimax, MinimaxReport::is_finite);
        dropped.unless("robust.likelihood", &mut robust.likelihood, LikelihoodReport::is_finite);
    }
    for c in &mut result.coefficients {
        dropped.unless("interval", &mut c.interval, Interval::is_finite);
    }
    look_at_parts(&mut result, &mut dropped);
    dropped.warn(&mut result.warnings);
    if !all(&result.spectrum.regularized.eigenvalues) {
        let message = "λ* raises an eigenvalue above the range of double precision";
        return Err(FitError::ExceedsDouble(Faults::one("regularization", message)));
    }
    if result.robust.as_ref().is_some_and(|r| {
        !(r.scale.is_none_or(f64::is_finite) && r.objective.is_finite() && r.weights.iter().all(|weights| all(weights)))
    }) {
        let message =
            "scale or sum of this estimator exceed the range of double precision: choose another scale or unit";
        return Err(FitError::ExceedsDouble(Faults::one("estimator", message)));
    }
    let residuals = &result.residuals;
    let sound = result.coefficients.iter().all(|c| all(&[c.value, c.least_squares, c.bias_bound]))
        && all(&result.spectrum.eigenvalues)
        && all(&result.regularization.filter_factors)
        && result.numerics.correct_digits.is_finite()
        && result.regularization.choices.iter().all(|c| all(&[c.bias_norm, c.rms]))
        && all(&[result.bias.norm, result.bias.sharp_bound, result.bias.coefficient_norm_limit])
        && all(&[residuals.rss, residuals.rms, residuals.least_squares_rss])
        && residuals.max_abs.is_none_or(f64::is_finite)
        && [&residuals.values, &residuals.fitted, &residuals.heights].into_iter().flatten().all(|list| all(list))
        && result.robust.as_ref().is_none_or(|r| all(&r.coefficients))
        && result.ridge_trace.iter().flatten().all(|point| point.k.is_finite() && all(&point.coefficients))
        && result.matrix_b.iter().flatten().all(|row| all(row));
    if sound { Ok(result) } else { Err(exceeds_double()) }
}
