//! A node named by its place among the posted ones.

/// A node: of a grid its row and column, or of any nodes its number in the order posted (of a grid
/// row by row). All count from 0, missing nodes included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(untagged, deny_unknown_fields),
    schema(example = json!({"row": 4, "column": 7}))
)]
pub enum NodeAt {
    /// Index in the order posted; grids count row by row.
    Index(usize),
    /// Cell of a grid: `z[row][column]` is at `(u[row], v[column])`.
    Cell {
        /// Index of u.
        row: usize,
        /// Index of v.
        column: usize,
    },
}
