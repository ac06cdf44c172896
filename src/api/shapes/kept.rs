//! Curves and surfaces kept with an iteration, as they are listed and answered.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::{
    api::{json_writer::Json, problem::Problem, text::Moment},
    jobs::{Cursor, Page, Shape, ShapeDraft, ShapeKind, ShapeSummary},
};

/// A shape that was built: the contract's name of its method, and the answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Built {
    pub method: String,
    /// JSON.
    pub result: Vec<u8>,
}

/// What a shape is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ShapeKind)]
pub enum ShapeKindName {
    Curve,
    Surface,
}

/// A curve or surface of an iteration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Shape)]
pub struct ShapeBody {
    pub id: Uuid,
    pub kind: ShapeKindName,
    /// The method that built it.
    pub method: String,
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// The request as it was posted. Where it has no points or nodes of its own, those of the iteration were taken.
    #[schema(value_type = Object)]
    pub request: Value,
    /// What `POST /v1/curves` or `POST /v1/surfaces` answers to it.
    #[schema(value_type = Object)]
    pub result: Value,
}

/// A shape in a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ShapeSummary)]
pub struct ShapeSummaryBody {
    pub id: Uuid,
    pub kind: ShapeKindName,
    /// The method that built it.
    pub method: String,
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
}

/// Some shapes of an iteration, oldest first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ShapePage)]
pub struct ShapePageBody {
    pub items: Vec<ShapeSummaryBody>,
    /// Where the next page begins; absent on the last one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next_cursor: Option<String>,
}

impl From<ShapeKind> for ShapeKindName {
    fn from(kind: ShapeKind) -> Self {
        match kind {
            ShapeKind::Curve => ShapeKindName::Curve,
            ShapeKind::Surface => ShapeKindName::Surface,
        }
    }
}

impl From<Page<ShapeSummary>> for ShapePageBody {
    fn from(page: Page<ShapeSummary>) -> Self {
        let item = |shape: ShapeSummary| ShapeSummaryBody {
            id: shape.id,
            kind: shape.kind.into(),
            method: shape.method,
            created_at: Moment(shape.created_at),
        };
        ShapePageBody { items: page.items.into_iter().map(item).collect(), next_cursor: page.next.map(Cursor::encode) }
    }
}

/// What is kept of a request and its answer, both as they are.
pub fn draft(kind: ShapeKind, request: &[u8], built: Built) -> Result<ShapeDraft, Problem> {
    let text = |bytes: &[u8]| std::str::from_utf8(bytes).map(Into::into).map_err(Problem::internal);
    Ok(ShapeDraft { kind, method: built.method, request: text(request)?, result: text(&built.result)? })
}

/// A kept shape as it is answered.
pub fn shape(shape: &Shape) -> Vec<u8> {
    let ShapeDraft { kind, method, request, result } = &shape.draft;
    let mut json = Json::with_capacity(256 + request.len() + result.len());
    let mut object = json.object();
    object
        .field("id", &shape.id)
        .string("kind", kind.name())
        .string("method", method)
        .field("created_at", &Moment(shape.created_at))
        .raw("request", request)
        .raw("result", result);
    object.end();
    json.into_bytes()
}
