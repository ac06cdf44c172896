//! The answer to a fit as a whole.

use std::sync::Arc;

use super::{
    accuracy::{Numerics, PerturbationReport},
    collinearity::CollinearityReport,
    constraints::ConstraintsReport,
    errors::{ErrorsReport, VarianceReport},
    estimable::EstimableSum,
    filtering::{FilterCollinearity, FilterReport},
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
use flankfit_numerics::Shared;

/// The result of a fit.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct FitResult {
    /// In the order of `powers`, `index` or `column`.
    pub coefficients: Vec<Coefficient>,
    /// The box on which mapped bases live; absent for a measurement matrix.
    pub domain: Option<Domain>,
    /// Eigenvalues of the Fisher information matrix before and after regularisation.
    pub spectrum: SpectrumReport,
    /// Regularisation that was applied, and the choices of the other criteria.
    pub regularization: RegularizationReport,
    /// Distance by which regularisation has moved the estimate, and its bounds.
    pub bias: BiasReport,
    /// Dependencies between the columns.
    #[cfg_attr(feature = "contract", schema(value_type = CollinearityReport))]
    pub collinearity: Arc<Shared<CollinearityReport>>,
    /// Present when `node_uncertainty` was given.
    pub perturbation: Option<PerturbationReport>,
    /// Residuals of the fitted function.
    pub residuals: ResidualReport,
    /// Present for every estimator but `least_squares`.
    pub robust: Option<RobustReport>,
    /// Condition, bias and error along λ*; present when `lambda_curve` was included.
    pub lambda_curve: Option<Vec<LambdaCurvePoint>>,
    /// The coefficients along k, ascending from 0; present with `include` of `ridge_trace` and
    /// ridge.
    pub ridge_trace: Option<Vec<RidgeTracePoint>>,
    /// The rows of B in the caller's columns; present when `matrix_b` was included.
    pub matrix_b: Option<Vec<Vec<f64>>>,
    /// B as a product; present with `matrix_b`.
    pub matrix_b_factors: Option<MatrixBFactors>,
    /// The data that other fits need: V, λ* and L, in the form of `regularization` of type
    /// `representative`. Present with `include` of `representative`, if `spectral` raised an
    /// eigenvalue.
    pub representative: Option<Piece>,
    /// Sums of the coefficients of nearly dependent terms that are well determined; present
    /// when `collinearity` was included and some terms are nearly dependent.
    pub estimable: Option<Vec<EstimableSum>>,
    /// Changes by each filter, in the order applied; present with filters.
    pub filters: Option<Vec<FilterReport>>,
    /// Present when there were filters.
    pub filter_collinearity: Option<FilterCollinearity>,
    /// Present with a `prior`.
    pub prior: Option<PriorReport>,
    /// Present with `constraints`.
    pub constraints: Option<ConstraintsReport>,
    /// Present when `covariance` was included.
    pub covariance: Option<Covariance>,
    /// Present with `predict`.
    pub predictions: Option<Predictions>,
    /// Present if sums were requested and the nodes determine the coefficients; a sum that double
    /// precision does not hold is `None`.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub sums: Option<Vec<Option<WeightedSum>>>,
    /// Present when `influence` was included and the nodes determine the coefficients.
    pub influence: Option<Influence>,
    /// Present if the model was chosen among several (`select`).
    pub selection: Option<Selection>,
    /// The fitted polynomial as a curve or surface; present when `shape` was included.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub shape: Option<Shape>,
    /// Present when `errors` were correlated.
    pub errors: Option<ErrorsReport>,
    /// Present when variances were estimated.
    pub variance: Option<VarianceReport>,
    /// Present if the nodes have uncertain positions.
    pub positions: Option<PositionsReport>,
    /// The fit without the nodes suspected of gross errors; present if there are any and the others
    /// determine it.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub without_suspected: Option<Box<FitResult>>,
    /// Arithmetic and correct digits.
    pub numerics: Numerics,
    /// Warnings about the fit; may be empty.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub warnings: Vec<Warning>,
}
