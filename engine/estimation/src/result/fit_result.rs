//! The answer to a fit as a whole.

use std::sync::Arc;

use super::{
    accuracy::{Numerics, PerturbationReport},
    collinearity::CollinearityReport,
    constraints::ConstraintsReport,
    errors::{ErrorsReport, VarianceReport},
    estimable::EstimableSum,
    filtering::FilteringReport,
    influence::Influence,
    matrix_b::MatrixBFactors,
    positions::PositionsReport,
    prediction::{Covariance, Predictions},
    prior::PriorReport,
    regularization::{BiasReport, LambdaCurvePoint, RegularizationReport, RidgeTracePoint},
    residuals::ResidualReport,
    robust::RobustReport,
    selection::Selection,
    shape::Shape,
    spectrum::SpectrumReport,
    sums::WeightedSum,
    term::Coefficient,
    warning::Warning,
};
use crate::spec::{Domain, Piece};

/// The answer to a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct FitResult {
    /// One entry for each term of the model.
    pub coefficients: Vec<Coefficient>,
    /// The box on which mapped bases live; `None` for a measurement matrix.
    pub domain: Option<Domain>,
    /// Eigenvalues of the Fisher information matrix before and after regularisation.
    pub spectrum: SpectrumReport,
    /// What regularisation did, and what other criteria would have chosen.
    pub regularization: RegularizationReport,
    /// How far regularisation has moved the estimate, and how far it can have.
    pub bias: BiasReport,
    /// How the columns depend on each other.
    pub collinearity: Arc<CollinearityReport>,
    /// How far uncertain nodes can move the coefficients; present when their uncertainty was given.
    pub perturbation: Option<PerturbationReport>,
    /// What the fitted function leaves of the heights.
    pub residuals: ResidualReport,
    /// Present for every estimator but least squares.
    pub robust: Option<RobustReport>,
    /// Present when `lambda_curve` was included.
    pub lambda_curve: Option<Vec<LambdaCurvePoint>>,
    /// Present when `ridge_trace` was included.
    pub ridge_trace: Option<Vec<RidgeTracePoint>>,
    /// Rows of B (m×n, in the caller's columns), present when `matrix_b` was included.
    pub matrix_b: Option<Vec<Vec<f64>>>,
    /// B as the product of Eq. 28, with the inequalities about it; likewise.
    pub matrix_b_factors: Option<MatrixBFactors>,
    /// What of the fit is used for others; present when `representative` was included and B is not
    /// 0.
    pub representative: Option<Piece>,
    /// Well determined sums of the coefficients of nearly dependent terms; present when
    /// `collinearity` was included and some terms are.
    pub estimable: Option<Vec<EstimableSum>>,
    /// Present when filters were asked for.
    pub filtering: Option<FilteringReport>,
    /// Present when something was known before.
    pub prior: Option<PriorReport>,
    /// Present when the function was constrained.
    pub constraints: Option<ConstraintsReport>,
    /// Present when `covariance` was included and there is an estimate of the noise.
    pub covariance: Option<Covariance>,
    /// Present when heights were asked for at places.
    pub predictions: Option<Predictions>,
    /// Present when sums were asked for and the nodes determine the coefficients; a sum that double
    /// precision does not hold is `None`.
    pub sums: Option<Vec<Option<WeightedSum>>>,
    /// Present when `influence` was included and the nodes determine the coefficients.
    pub influence: Option<Influence>,
    /// Present when the model was chosen out of several.
    pub selection: Option<Selection>,
    /// The fitted polynomial as a curve or surface; present when `shape` was included.
    pub shape: Option<Shape>,
    /// Present when errors are correlated.
    pub errors: Option<ErrorsReport>,
    /// Present when variances were estimated.
    pub variance: Option<VarianceReport>,
    /// Present when positions of nodes were taken as off.
    pub positions: Option<PositionsReport>,
    /// The fit without the nodes suspected of gross errors; present if there are any and the others
    /// determine it.
    pub without_suspected: Option<Box<FitResult>>,
    /// Arithmetic and correct digits.
    pub numerics: Numerics,
    /// What a reader must know of this fit.
    pub warnings: Vec<Warning>,
}
