//! Checked nodes, and how a fit sees them: counted, weighted, in blocks, summed.

mod blocks;
mod excluded;
pub(super) mod folds;
mod heights;
mod nodes;
mod sample;
mod white_rows;

pub use blocks::{Form, join};
pub(crate) use excluded::{masked, without};
pub(crate) use folds::Partition;
pub(crate) use heights::Heights;
pub(crate) use nodes::negative_weight;
pub use nodes::{Curve, Grid, Matrix, Nodes, Scattered};
pub(crate) use sample::Sample;
pub(crate) use white_rows::WhiteRows;
