//! Wire form of the evaluation of a surface: request and response.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    contract::{Pair, Triple},
    json::request::request,
    shapes::places::Values,
    warning::WarningBody,
};
use flankfit_engine::geometry::{contract::Point, surface::SurfaceShape};

request! {
    /// A surface and the parameters at which it is evaluated: `at`, or every pair of `grid`.
    #[schema(as = EvaluateSurface)]
    pub struct EvaluateSurfaceBody as EvaluateSurfaceMembers {
        required surface: SurfaceShape,
        /// Pairs [u, v] within the surface's domain, in any order.
        #[schema(value_type = Option<Vec<Pair>>)]
        optional at: Vec<[f64; 2]>,
        optional grid: ParameterGridBody,
        /// Highest order of the returned derivatives. Default 0.
        #[schema(minimum = 0, maximum = 2)]
        optional derivatives: usize,
        /// Parts that are returned only when requested.
        optional include: Vec<SurfaceIncludeName>,
    }
}

request! {
    /// Parameters of a grid: every u with every v, v running fastest.
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    #[schema(as = ParameterGrid)]
    pub struct ParameterGridBody as ParameterGridMembers {
        /// In any order.
        required u: Vec<f64>,
        /// In any order.
        required v: Vec<f64>,
    }
}

/// Optional parts of the result. `normals` are always included with one derivative, `curvatures`
/// with two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = SurfaceInclude)]
pub enum SurfaceIncludeName {
    FundamentalForms,
    Area,
}

/// A surface at parameters, in the order of `at` or of the grid.
#[skip_serializing_none]
#[derive(Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = SurfaceValues)]
pub struct SurfaceValuesBody {
    /// Points of the surface; numbers for a graph.
    #[schema(value_type = Vec<Point>)]
    pub values: Values,
    /// With one derivative or more.
    pub derivatives: Option<SurfaceDerivativesBody>,
    /// With one derivative or more: unit normals along S_u × S_v; for a graph those of (u, v, z).
    /// Absent, with a warning, where one of them does not exist.
    #[schema(value_type = Option<Vec<Triple>>)]
    pub normals: Option<Values>,
    /// With two derivatives.
    pub curvatures: Option<CurvaturesBody>,
    pub fundamental_forms: Option<FundamentalFormsBody>,
    pub area: Option<AreaBody>,
    /// Warnings about the result.
    pub warnings: Vec<WarningBody>,
}

/// Partial derivatives.
#[skip_serializing_none]
#[derive(Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = SurfaceDerivatives)]
pub struct SurfaceDerivativesBody {
    /// ∂S/∂u at each parameter.
    #[schema(value_type = Vec<Point>)]
    pub u: Values,
    /// ∂S/∂v at each parameter.
    #[schema(value_type = Vec<Point>)]
    pub v: Values,
    /// ∂²S/∂u² at each parameter.
    #[schema(value_type = Option<Vec<Point>>)]
    pub uu: Option<Values>,
    /// ∂²S/∂u∂v at each parameter.
    #[schema(value_type = Option<Vec<Point>>)]
    pub uv: Option<Values>,
    /// ∂²S/∂v² at each parameter.
    #[schema(value_type = Option<Vec<Point>>)]
    pub vv: Option<Values>,
}

/// Curvatures, > 0 where the surface bends towards its normal.
#[derive(Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = Curvatures)]
pub struct CurvaturesBody {
    /// Product of the two principal curvatures, 1/length².
    #[schema(value_type = Vec<f64>)]
    pub gaussian: Values,
    /// Half the sum of the two principal curvatures, 1/length.
    #[schema(value_type = Vec<f64>)]
    pub mean: Values,
    /// The greater and the lesser one.
    #[schema(value_type = Vec<Pair>)]
    pub principal: Values,
    /// Unit tangents along which the greater one is taken; the other is at right angles.
    #[schema(value_type = Vec<Triple>)]
    pub direction: Values,
}

/// The first fundamental form (E, F, G) and the second one (L, M, N).
#[derive(Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = FundamentalForms)]
pub struct FundamentalFormsBody {
    /// `[E, F, G]` at each parameter.
    #[schema(value_type = Vec<Triple>)]
    pub first: Values,
    /// `[L, M, N]` at each parameter.
    #[schema(value_type = Vec<Triple>)]
    pub second: Values,
}

/// Area of the whole surface.
#[derive(Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = Area)]
pub struct AreaBody {
    /// In the square of the unit of length of the request.
    pub value: f64,
    /// Estimated error.
    pub error: f64,
}
