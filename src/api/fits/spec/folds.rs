//! Which nodes blocked cross-validation leaves out together, as it is written.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::json::present::present;
use flankfit_engine::estimation::spec::{Folds, FoldsBy};

/// The blocks of nodes that cross-validation leaves out together, for the criterion `blocked_cv` of
/// a regularisation and for `select`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Folds, example = json!({"by": "rows", "count": 5}))]
pub struct FoldsBody {
    /// Nodes that are left out together.
    pub by: FoldsByName,
    /// Number of blocks, each of neighbouring rows (columns, lines): at least 2, at most one for
    /// each row. Default 10, or one for each row where there are fewer.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 2)]
    pub count: Option<usize>,
    /// With `lines` only, and required there: number of the scan line of each node, in the order
    /// posted (a grid row by row); −2⁶³ to 2⁶³ − 1.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub line: Option<Vec<i64>>,
}

/// Blocks that are left out as a whole. `rows`: nodes of one u (of one x on a curve), or single
/// rows of a measurement matrix; `columns`: nodes of one v; `lines`: nodes of one scan line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = FoldsBy)]
pub enum FoldsByName {
    Rows,
    Columns,
    Lines,
}

impl From<&Folds> for FoldsBody {
    fn from(folds: &Folds) -> Self {
        let (by, line) = match &folds.by {
            FoldsBy::Rows => (FoldsByName::Rows, None),
            FoldsBy::Columns => (FoldsByName::Columns, None),
            FoldsBy::Lines(line) => (FoldsByName::Lines, Some(line.clone())),
        };
        FoldsBody { by, count: folds.count, line }
    }
}
