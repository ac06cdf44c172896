//! A fit request: nodes, specification and measurand.

use serde::Serialize;
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{include::IncludeName, nodes::PostedNodes};
use crate::api::{json::request::request, measurand::axes::MeasurandBody, tables::mapping::MappingBody};
use flankfit_engine::estimation::spec::{
    Constraint, Domain, ErrorModel, Estimator, Filter, Folds, Model, NodeAt, NodeUncertainty, Predict, Prior,
    Regularization, Scaling, Select, Variance,
};

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
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct FitForm {
    /// The fit request without `nodes`, as JSON.
    pub spec: FitFormSpec,
    /// A table of nodes in any form accepted by `POST /v1/nodes/read`, such as CSV with a header
    /// `u,v,z[,weight]` or `x,y[,weight]`; an empty height is a missing node. Its flank, tooth and
    /// axes are used if `spec` has none.
    #[schema(value_type = String, format = Binary)]
    pub nodes: Vec<u8>,
    /// Mapping of the table.
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
    /// A fit without its nodes.
    #[serde(deny_unknown_fields)]
    #[schema(as = FitSpec)]
    pub struct FitSpecBody as FitSpecMembers {
        required model: Model,
        flatten fit: FitFields,
        /// The box on which mapped bases live; by default the smallest box of the counted nodes.
        optional domain: Domain,
        optional prior: Prior,
        /// Conditions on slope or curvature of the fitted curve or surface. `regularization` must
        /// then be `none`, and the estimator `least_squares`.
        #[schema(max_items = 16)]
        optional constraints: Vec<Constraint>,
        /// Heights, slopes and bands at places of the domain.
        optional predict: Predict,
        optional select: Select,
        optional folds: Folds,
        /// Nodes that the fit treats as missing; each is named once. They remain in the stored
        /// nodes, and `spec` lists them.
        #[schema(example = json!([{"row": 4, "column": 7}]))]
        optional exclude: Vec<NodeAt>,
    }
}

request! {
    /// How is fitted, whatever the model and wherever the nodes come from.
    #[derive(Default)]
    pub struct FitFields as FitFieldsMembers {
        optional scaling: Scaling,
        /// Default for fits: `first_order` with λ* by `min_mse`, or `none` with a prior. Default
        /// for a curve, a surface or a flank: `none`.
        optional regularization: Regularization,
        optional estimator: Estimator,
        /// Norm limit r ≥ ‖A‖ of Ineq. 51, in the scaled columns, for bias bounds and intervals;
        /// they are valid only if it holds. Use a source other than these nodes
        /// (docs/explanation/intervals.md). By default r is estimated, and used for bounds only.
        #[schema(exclusive_minimum = 0)]
        optional coefficient_norm_limit: f64,
        /// Standard deviation of a height of weight 1, in the unit of the heights; by default
        /// estimated from the residuals.
        #[schema(exclusive_minimum = 0)]
        optional noise_sigma: f64,
        optional node_uncertainty: NodeUncertainty,
        optional errors: ErrorModel,
        optional variance: Variance,
        /// Level of confidence intervals, above 0.5 and below 1, by default 0.95.
        #[schema(exclusive_minimum = 0.5, exclusive_maximum = 1, example = 0.95)]
        optional level: f64,
        /// Optional parts of the result.
        optional include: Vec<IncludeName>,
        /// Applied to the heights before the fit, in this order.
        #[schema(max_items = 16)]
        optional filters: Vec<Filter>,
    }
}
