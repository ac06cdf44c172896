//! Excluded nodes, in wire form.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use flankfit_engine::estimation::spec::NodeAt;

/// A node: of a grid its row and column, or of any nodes its number in the order posted (of a grid
/// row by row). All count from 0, missing nodes included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = NodeAt, example = json!({"row": 4, "column": 7}))]
pub enum NodeAtBody {
    Cell(NodeCellBody),
    Index(usize),
}

/// A node of a grid: `z[row][column]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = NodeCell)]
pub struct NodeCellBody {
    /// Index of u.
    pub row: usize,
    /// Index of v.
    pub column: usize,
}

impl From<NodeAtBody> for NodeAt {
    fn from(body: NodeAtBody) -> Self {
        match body {
            NodeAtBody::Cell(NodeCellBody { row, column }) => NodeAt::Cell { row, column },
            NodeAtBody::Index(index) => NodeAt::Index(index),
        }
    }
}

impl From<NodeAt> for NodeAtBody {
    fn from(at: NodeAt) -> Self {
        match at {
            NodeAt::Cell { row, column } => NodeAtBody::Cell(NodeCellBody { row, column }),
            NodeAt::Index(index) => NodeAtBody::Index(index),
        }
    }
}
