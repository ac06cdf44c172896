//! What a fit request asks for, as it is written: models, regularisations, and the rest of the
//! spec.
//!
//! The structs here are read (by [`crate::api::fits::reader`]), written (specs are stored as
//! canonical JSON) and documented (OpenAPI). Unions carry `type` inside their variants, which is
//! what client generators cope with best.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{constraint::ConstraintBody, exclude::NodeAtBody, filters::FilterBody, nodes::PostedNodes};
pub use super::{
    count::CountBody,
    knots::{KnotsBody, WeightsBody},
};
pub use super::{
    errors::*,
    estimator::*,
    folds::FoldsBody,
    include::IncludeName,
    predict::*,
    prior::PriorBody,
    select::SelectBody,
    terms::{TermsBody, TermsName},
};
pub use super::{model::*, regularization::*, scheme::SchemeName};
pub use crate::api::shapes::degree::{DegreeBody, SpansBody};
pub use crate::api::shapes::domain::DomainBody;
use crate::api::{
    json::{present::present, request::request},
    measurand::axes::MeasurandBody,
    tables::mapping::MappingBody,
};
use flankfit_engine::estimation::spec::PositionKind;

/// A fit request.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct FitRequest {
    #[serde(flatten)]
    #[schema(inline)]
    pub nodes: PostedNodes,
    #[serde(flatten)]
    #[schema(inline)]
    pub spec: FitSpecBody,
    #[serde(flatten)]
    #[schema(inline)]
    pub measurand: MeasurandBody,
}

/// A fit request as a form (`multipart/form-data`).
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct FitForm {
    /// The fit request without `nodes`, as JSON.
    pub spec: FitFormSpec,
    /// A table of nodes in any form that `POST /v1/nodes/read` reads, such as CSV with a header
    /// `u,v,z[,weight]` or `x,y[,weight]`; an empty height is a missing node. Its flank, tooth and
    /// axes are used where `spec` has none.
    #[schema(value_type = String, format = Binary)]
    pub nodes: Vec<u8>,
    /// Mapping of the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mapping: Option<MappingBody>,
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

request! {
    /// Everything about a fit but the nodes.
    #[serde(deny_unknown_fields)]
    #[schema(as = FitSpec)]
    pub struct FitSpecBody as FitSpecMembers {
        required model: ModelBody,
        flatten fit: FitFields,
        /// The box on which mapped bases live; by default the smallest box of the counted nodes.
        optional domain: DomainBody,
        optional prior: PriorBody,
        /// Conditions on slope or curvature of the fitted curve or surface. `regularization` must
        /// then be `none`, and the estimator `least_squares`.
        #[schema(max_items = 16)]
        optional constraints: Vec<ConstraintBody>,
        /// Heights, slopes and bands at places of the domain.
        optional predict: PredictBody,
        optional select: SelectBody,
        optional folds: FoldsBody,
        /// Nodes that the fit treats as missing; each is named once. They remain in the stored
        /// nodes, and `spec` lists them.
        #[schema(example = json!([{"row": 4, "column": 7}]))]
        optional exclude: Vec<NodeAtBody>,
    }
}

request! {
    /// How is fitted, whatever the model and wherever the nodes come from.
    #[derive(Default)]
    pub struct FitFields as FitFieldsMembers {
        optional scaling: ScalingName,
        /// Default for fits: `first_order` with λ* by `min_mse`, or `none` with a prior. Default
        /// for a curve, a surface or a flank: `none`.
        optional regularization: RegularizationBody,
        optional estimator: EstimatorBody,
        /// Norm limit r ≥ ‖A‖ of Ineq. 51, in the scaled columns, for bias bounds and intervals;
        /// they are valid only if it holds. Take it from a source other than these nodes
        /// (docs/intervals.md). By default r is estimated, and used for bounds only.
        #[schema(exclusive_minimum = 0)]
        optional coefficient_norm_limit: f64,
        /// Standard deviation of a height of weight 1, in the unit of the heights; by default
        /// estimated from the residuals.
        #[schema(exclusive_minimum = 0)]
        optional noise_sigma: f64,
        optional node_uncertainty: NodeUncertaintyBody,
        optional errors: ErrorsBody,
        optional variance: VarianceBody,
        /// Level of confidence intervals, above 0.5 and below 1; default 0.95.
        #[schema(exclusive_minimum = 0.5, exclusive_maximum = 1, example = 0.95)]
        optional level: f64,
        /// Optional parts of the answer.
        optional include: Vec<IncludeName>,
        /// Applied to the heights before the fit, in this order.
        #[schema(max_items = 16)]
        optional filters: Vec<FilterBody>,
    }
}

/// Standard uncertainties of a node, in the caller's unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = NodeUncertainty)]
pub struct NodeUncertaintyBody {
    /// Standard uncertainty of each abscissa (of each entry of a measurement matrix).
    #[schema(minimum = 0)]
    pub position: f64,
    /// Standard uncertainty of the height.
    #[schema(minimum = 0)]
    pub height: f64,
    /// Kind of the uncertainty where `position` is not 0; default `measured`. Robust estimators,
    /// measurement matrices, streams, shapes near points and `height` 0 treat positions as exact:
    /// there a warning says so, and a kind is refused.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub position_kind: Option<PositionKindName>,
}

/// Kind of position errors. `measured`: the reading is wrong (orthogonal distance regression: the
/// true positions are estimated with the coefficients). `nominal`: the position reached differs
/// from the given one (effective variance: steep places weigh less). In both cases a node has the
/// variance height²/weight + slope² position², up to a factor that follows from `sigma`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = PositionKind)]
pub enum PositionKindName {
    Measured,
    Nominal,
}

impl From<PositionKindName> for PositionKind {
    fn from(name: PositionKindName) -> Self {
        match name {
            PositionKindName::Measured => PositionKind::Measured,
            PositionKindName::Nominal => PositionKind::Nominal,
        }
    }
}

impl From<PositionKind> for PositionKindName {
    fn from(kind: PositionKind) -> Self {
        match kind {
            PositionKind::Measured => PositionKindName::Measured,
            PositionKind::Nominal => PositionKindName::Nominal,
        }
    }
}

/// Scaling of X's columns before the eigen analysis; default `unit_length`, `none` is the paper's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ScalingName {
    UnitLength,
    None,
    Standardized,
}
