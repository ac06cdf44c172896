//! The functions whose mixture is fitted, as they are written.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    knots::{KnotsBody, WeightsBody},
    terms::TermsBody,
};
use crate::api::{
    json::{present::present, tags::tags},
    shapes::degree::{DegreeBody, SpansBody},
};

/// The basis functions of the fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
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
    pub terms: Option<TermsBody>,
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
    /// For NURBS: one weight above 0 for each control point, for a surface in rows along u. They
    /// are given, not fitted.
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
