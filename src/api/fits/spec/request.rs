//! What a fit request asks for, as it is written: models, regularisations, and the rest of the
//! spec.
//!
//! The structs here are read (by [`crate::api::fits::reader`]), written (specs are stored as
//! canonical JSON) and documented (OpenAPI). Unions carry `type` inside their variants, which is
//! what client generators cope with best.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

pub use super::regularization::*;
pub use super::{
    count::CountBody,
    knots::{KnotsBody, WeightsBody},
};
pub use super::{estimator::*, include::IncludeName};
use super::{filters::FilterBody, nodes::NodesBody};
pub use crate::api::shapes::degree::{DegreeBody, SpansBody};
pub use crate::api::shapes::domain::DomainBody;
use crate::api::{
    json::{present::present, tags::tags, text::ShortText},
    measurand::{
        axes::{AxesBody, MeasurandBody},
        side::SideName,
    },
};

// Declared for the document; `crate::api::fits::reader` reads it.
/// A fit request.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FitRequest {
    pub nodes: NodesBody,
    pub model: ModelBody,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scaling: Option<ScalingName>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub regularization: Option<RegularizationBody>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimator: Option<EstimatorBody>,
    /// The box on which mapped bases live; by default the smallest box of the counted nodes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub domain: Option<DomainBody>,
    /// r ≥ ‖A‖ of Ineq. 51, in the scaled columns; by default estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0)]
    pub coefficient_norm_limit: Option<f64>,
    /// Standard deviation of a height of weight 1, in the caller's unit; by default estimated from
    /// the residuals.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0)]
    pub noise_sigma: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node_uncertainty: Option<NodeUncertaintyBody>,
    /// What is answered only when asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub include: Option<Vec<IncludeName>>,
    /// Applied to the heights before the fit, in this order.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(max_items = 16)]
    pub filters: Option<Vec<FilterBody>>,
    /// The flank that was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flank: Option<SideName>,
    /// The tooth that was measured, as on traces: its number from 1, or a name.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, min_length = 1, max_length = 200, example = "1")]
    pub tooth: Option<ShortText>,
    /// What the axes of the nodes mean.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axes: Option<AxesBody>,
}

/// A fit request as a form (`multipart/form-data`).
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct FitForm {
    /// The fit request without `nodes`, as JSON.
    pub spec: FitFormSpec,
    /// CSV with a header `u,v,z[,weight]` or `x,y[,weight]`; an empty height is a missing node.
    #[schema(value_type = String, format = Binary)]
    pub nodes: Vec<u8>,
}

/// A fit request without nodes.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct FitFormSpec {
    #[serde(flatten)]
    #[schema(inline)]
    pub spec: FitSpecBody,
    #[serde(flatten)]
    #[schema(inline)]
    pub measurand: MeasurandBody,
}

/// Everything about a fit but the nodes.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = FitSpec)]
pub struct FitSpecBody {
    pub model: ModelBody,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scaling: Option<ScalingName>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub regularization: Option<RegularizationBody>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimator: Option<EstimatorBody>,
    /// The box on which mapped bases live; by default the smallest box of the counted nodes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub domain: Option<DomainBody>,
    /// r ≥ ‖A‖ of Ineq. 51, in the scaled columns; by default estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0)]
    pub coefficient_norm_limit: Option<f64>,
    /// Standard deviation of a height of weight 1, in the caller's unit; by default estimated from
    /// the residuals.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0)]
    pub noise_sigma: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node_uncertainty: Option<NodeUncertaintyBody>,
    /// What is answered only when asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub include: Option<Vec<IncludeName>>,
    /// Applied to the heights before the fit, in this order.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(max_items = 16)]
    pub filters: Option<Vec<FilterBody>>,
}

/// The functions whose mixture is fitted.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = Model, discriminator(property_name = "type", mapping(
    ("polynomial" = "#/components/schemas/PolynomialModel"),
    ("b_spline" = "#/components/schemas/BSplineModel"),
    ("linear" = "#/components/schemas/LinearModel")
)))]
pub enum ModelBody {
    Polynomial(PolynomialModel),
    BSpline(BSplineModel),
    Linear(LinearModel),
}

/// Polynomials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PolynomialModel {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: PolynomialTag,
    pub degree: DegreeBody,
    /// Default `monomial`.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub basis: Option<BasisName>,
    /// Default `tensor`.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub terms: Option<TermsName>,
}

/// B-splines, or NURBS with `weights`; either `knots` or `spans`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BSplineModel {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: BSplineTag,
    pub degree: DegreeBody,
    /// Full knot vectors, ascending; the last span is closed on the right.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub knots: Option<KnotsBody>,
    /// Equal spans over the domain.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub spans: Option<SpansBody>,
    /// Of NURBS: one weight above 0 for each control point, for a surface in rows along u. They are
    /// given, not fitted.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub weights: Option<WeightsBody>,
}

/// The columns of a measurement matrix as they are; for nodes of type `matrix`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LinearModel {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: LinearTag,
}

/// Standard uncertainties of a node, in the caller's unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = NodeUncertainty)]
pub struct NodeUncertaintyBody {
    /// Of each abscissa (of each entry for a measurement matrix).
    #[schema(minimum = 0)]
    pub position: f64,
    /// Of the height.
    #[schema(minimum = 0)]
    pub height: f64,
}

tags! {
    PolynomialTag = Polynomial,
    BSplineTag = BSpline,
    LinearTag = Linear,
}

/// Functions of a polynomial model. `monomial` means the caller's raw u and v; the others live on
/// the domain mapped to [-1, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum BasisName {
    Monomial,
    Chebyshev,
    Legendre,
}

/// Which products of powers: every one up to the degree of each axis, or those whose degrees add up
/// to at most the degree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum TermsName {
    Tensor,
    Total,
}

/// Of X's columns before the eigen analysis; default `unit_length`, `none` is the paper's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ScalingName {
    UnitLength,
    None,
    Standardized,
}
