//! Parts of the report that every kind of regularisation fills in.

use super::context::Context;
use crate::{
    result::{Choice, RegularizationKind, RegularizationReport, RegularizedSpectrum},
    spec::ChosenBy,
};
use flankfit_numerics::check::Faults;

/// Numbers of B that an answer may hold.
const MOST_OF_B: usize = 1_000_000;

/// Refuses a matrix B of more entries than are returned.
pub(super) fn check_b(rows: usize, columns: usize) -> Result<(), Faults> {
    if rows * columns <= MOST_OF_B {
        return Ok(());
    }
    let message = format_args!("B has {rows} × {columns} entries here; at most {MOST_OF_B} are returned");
    Err(Faults::one("include", message))
}

/// Makes an empty report of `kind`.
pub(super) fn report(kind: RegularizationKind) -> RegularizationReport {
    RegularizationReport {
        kind,
        scheme: None,
        count: None,
        lambda_star: None,
        rank: None,
        shrinkage_factor: None,
        lambda_star_interval: None,
        gamma: None,
        criterion: None,
        filter_factors: Vec::new(),
        matrix_norm_squared: None,
        largest_eigenvalue_bound: None,
        predicted_mse_corrected: None,
        squared_error_interval: None,
        representative: None,
        choices: Vec::new(),
    }
}

/// Condition of positive eigenvalues; `None` where one is 0.
pub(super) fn condition(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (mut low, mut high) = (f64::INFINITY, 0.0f64);
    for value in values {
        (low, high) = (low.min(value), high.max(value));
    }
    Some(high / low).filter(|c| low > 0.0 && c.is_finite())
}

pub(super) fn log10_determinant(values: impl Iterator<Item = f64>) -> Option<f64> {
    Some(values.map(f64::log10).sum::<f64>()).filter(|sum| sum.is_finite())
}

/// Report on eigenvalues in the order of their directions.
pub(crate) fn regularized_spectrum(eigenvalues: Vec<f64>) -> RegularizedSpectrum {
    RegularizedSpectrum {
        condition: condition(eigenvalues.iter().copied()),
        log10_determinant: log10_determinant(eigenvalues.iter().copied()),
        eigenvalues,
    }
}

/// Least squares is all that there was to choose.
pub(super) fn unregularized(context: &Context) -> RegularizationReport {
    let Context { spectrum, least_squares, .. } = *context;
    let least = Choice {
        criterion: ChosenBy::LeastSquares,
        lambda_star: None,
        condition: regularized_spectrum(spectrum.lambda.clone()).condition,
        bias_norm: 0.0,
        predicted_mse: context.variance.map(|v| v * spectrum.lambda.iter().map(|l| 1.0 / l).sum::<f64>()),
        rms: (least_squares.rss / context.weight).sqrt(),
    };
    RegularizationReport { choices: vec![least], ..report(RegularizationKind::None) }
}
