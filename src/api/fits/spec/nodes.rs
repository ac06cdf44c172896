//! Node sets in the OpenAPI document. Read by [`crate::api::fits::reader`] and written by
//! [`crate::api::fits::nodes_text`], not by serde.

use serde::Serialize;
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{fits::reader::nodes::RawNodes, json::request::request};

request! {
    /// The nodes of a request.
    pub struct PostedNodes as PostedNodesMembers {
        required nodes: NodesBody as RawNodes,
    }
}

/// Measured nodes, in the caller's own length unit.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
#[schema(as = Nodes)]
pub enum NodesBody {
    /// One boundary curve y(x); abscissae in any order, repetitions are repeated measurements.
    Curve(CurveNodes),
    /// One surface z(u, v) at arbitrary places.
    Scattered(ScatteredNodes),
    /// One surface on the crossings of two axes.
    Grid(GridNodes),
    /// The measurement matrix itself, row by row.
    Matrix(MatrixNodes),
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CurveNodes {
    /// Abscissae of the heights, in any order.
    #[schema(min_items = 1)]
    pub x: Vec<f64>,
    /// The height at each x.
    #[schema(min_items = 1)]
    pub y: Vec<f64>,
    /// Multiplies the squared residual; 0 leaves the node out.
    pub weight: Option<Vec<f64>>,
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ScatteredNodes {
    /// First coordinate of each node.
    #[schema(min_items = 1)]
    pub u: Vec<f64>,
    /// Second coordinate of each node.
    #[schema(min_items = 1)]
    pub v: Vec<f64>,
    /// Height of each node.
    #[schema(min_items = 1)]
    pub z: Vec<f64>,
    /// Multiplies the squared residual; 0 leaves the node out.
    pub weight: Option<Vec<f64>>,
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct GridNodes {
    /// Strictly ascending.
    #[schema(min_items = 1)]
    pub u: Vec<f64>,
    /// Strictly ascending.
    #[schema(min_items = 1)]
    pub v: Vec<f64>,
    /// One row for each u, in it one height for each v; `null` is a missing node.
    #[schema(min_items = 1)]
    pub z: Vec<Vec<Option<f64>>>,
    /// `false` marks a missing node.
    pub valid: Option<Vec<Vec<bool>>>,
    /// Multiplies the squared residual; 0 leaves the node out.
    pub weight: Option<Vec<Vec<f64>>>,
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MatrixNodes {
    /// The measurement matrix, one row for each measurement.
    #[schema(min_items = 1)]
    pub x: Vec<Vec<f64>>,
    /// The measured value of each row.
    #[schema(min_items = 1)]
    pub y: Vec<f64>,
    /// Names of the columns, all different.
    pub names: Option<Vec<String>>,
    /// Multiplies the squared residual; 0 leaves the row out.
    pub weight: Option<Vec<f64>>,
}
