//! The answer to a fit, as it is documented and as clients read it.
//!
//! A value that does not exist is left out: there is no `null` and no invented number. Answers are
//! written by [`super::text`], which never makes these bodies; its tests hold the two together.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{parts::*, robust::RobustBody};
use crate::api::{
    fits::spec::{
        filters::{FilterCollinearity, FilterResult},
        request::FitSpecBody,
    },
    shapes::{curve_shape::CurveBody, domain::DomainBody, surface_shape::SurfaceBody},
    warning::WarningBody,
};

/// The answer to a fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FitResult)]
pub struct FitResultBody {
    /// In the order of `powers`, `index` or `column`.
    pub coefficients: Vec<CoefficientBody>,
    /// The box on which mapped bases live; absent for a measurement matrix.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub domain: Option<DomainBody>,
    /// The fitted curve, where the model is `b_spline` and the nodes are of type `curve`; its
    /// control points are the coefficients.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve: Option<CurveBody>,
    /// The fitted surface, where the model is `b_spline` and the nodes have u and v; its control
    /// points are the coefficients.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<SurfaceBody>,
    pub spectrum: SpectrumBody,
    pub regularization: RegularizationResult,
    pub bias: BiasBody,
    pub collinearity: CollinearityBody,
    /// Present when `node_uncertainty` was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub perturbation: Option<PerturbationBody>,
    pub residuals: ResidualsBody,
    /// Present for every estimator but `least_squares`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robust: Option<RobustBody>,
    /// Condition, bias and error along λ*; present when `lambda_curve` was included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lambda_curve: Option<Vec<LambdaCurvePointBody>>,
    /// The coefficients along k, ascending from 0; present when `ridge_trace` was included and
    /// ridge asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ridge_trace: Option<Vec<RidgeTracePointBody>>,
    /// The rows of B in the caller's columns; present when `matrix_b` was included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matrix_b: Option<Vec<Vec<f64>>>,
    /// What each filter changed, in the order applied; present when there were filters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filters: Option<Vec<FilterResult>>,
    /// Present when there were filters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filter_collinearity: Option<FilterCollinearity>,
    pub numerics: NumericsBody,
    /// What to know about the answer; empty where there is nothing to say.
    pub warnings: Vec<WarningBody>,
    pub provenance: ProvenanceBody,
    /// What was fitted, with every default filled in: a request of its own, but for the nodes. Of
    /// `POST /v1/fits`; a fit that is kept has it beside its result.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<FitSpecBody>)]
    pub spec: Option<serde_json::Value>,
}
