use flankfit_numerics::check::Fault;
use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::fault;
use crate::spec::FoldsBy;

/// The blocks of nodes that cross-validation leaves out together, for the criterion `blocked_cv` of
/// a regularisation and for `select`.
#[skip_serializing_none]
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"by": "rows", "count": 5}))]
pub(in crate::spec) struct Folds {
    /// Nodes that form a block.
    by: By,
    /// Number of blocks, each of neighbouring rows (columns, lines): at least 2, at most one for
    /// each row. Default 10, or one for each row where there are fewer.
    #[schema(minimum = 2)]
    count: Option<usize>,
    /// With `lines` only, and required there: number of the scan line of each node, in the order
    /// posted (a grid row by row); −2⁶³ to 2⁶³ − 1.
    line: Option<Vec<i64>>,
}

/// Blocks of cross-validation. `rows`: nodes of one u (of one x on a curve), or single rows of a
/// measurement matrix; `columns`: nodes of one v; `lines`: nodes of one scan line.
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = FoldsBy)]
pub(in crate::spec) enum By {
    Rows,
    Columns,
    Lines,
}

impl TryFrom<Folds> for super::super::Folds {
    type Error = Fault;

    fn try_from(Folds { by, count, line }: Folds) -> Result<Self, Fault> {
        let by = match (by, line) {
            (By::Rows, None) => FoldsBy::Rows,
            (By::Columns, None) => FoldsBy::Columns,
            (By::Lines, Some(line)) => FoldsBy::Lines(line),
            (By::Lines, None) => return Err(fault("line", "missing; `lines` needs the line of each node")),
            (_, Some(_)) => return Err(fault("line", "only `lines` takes it")),
        };
        Ok(Self { by, count })
    }
}

impl From<super::super::Folds> for Folds {
    fn from(super::super::Folds { by, count }: super::super::Folds) -> Self {
        let (by, line) = match by {
            FoldsBy::Rows => (By::Rows, None),
            FoldsBy::Columns => (By::Columns, None),
            FoldsBy::Lines(line) => (By::Lines, Some(line)),
        };
        Folds { by, count, line }
    }
}
