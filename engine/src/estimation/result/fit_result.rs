//! The answer to a fit as a whole.

use std::sync::Arc;

use super::{
    accuracy::{Numerics, PerturbationReport},
    collinearity::CollinearityReport,
    filtering::FilteringReport,
    regularization::{BiasReport, LambdaCurvePoint, RegularizationReport, RidgeTracePoint},
    residuals::ResidualReport,
    robust::RobustReport,
    spectrum::SpectrumReport,
    term::Coefficient,
    warning::Warning,
};
use crate::estimation::spec::Domain;

#[derive(Clone, Debug, PartialEq)]
pub struct FitResult {
    pub coefficients: Vec<Coefficient>,
    /// The box on which mapped bases live; `None` for a measurement matrix.
    pub domain: Option<Domain>,
    pub spectrum: SpectrumReport,
    pub regularization: RegularizationReport,
    pub bias: BiasReport,
    pub collinearity: Arc<CollinearityReport>,
    pub perturbation: Option<PerturbationReport>,
    pub residuals: ResidualReport,
    /// Present for every estimator but least squares.
    pub robust: Option<RobustReport>,
    /// Present when `lambda_curve` was included.
    pub lambda_curve: Option<Vec<LambdaCurvePoint>>,
    /// Present when `ridge_trace` was included.
    pub ridge_trace: Option<Vec<RidgeTracePoint>>,
    /// Rows of B (m×n, in the caller's columns), present when `matrix_b` was included.
    pub matrix_b: Option<Vec<Vec<f64>>>,
    /// Present when filters were asked for.
    pub filtering: Option<FilteringReport>,
    pub numerics: Numerics,
    pub warnings: Vec<Warning>,
}
