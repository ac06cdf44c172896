//! A node named by its place among the posted ones.

/// A node named by its place among the posted ones, missing ones included; numbers count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
