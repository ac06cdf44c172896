//! The intervals that parameters run over.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Intervals of the parameters. A curve has `u` only.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Domain)]
#[serde(deny_unknown_fields)]
pub struct DomainBody {
    /// Interval of u (of x for a curve): [min, max].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Vec<f64>>, min_items = 2, max_items = 2, example = json!([0.0, 1.0]))]
    pub u: Option<[f64; 2]>,
    /// Interval of v: [min, max].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Vec<f64>>, min_items = 2, max_items = 2, example = json!([0.0, 1.0]))]
    pub v: Option<[f64; 2]>,
}
