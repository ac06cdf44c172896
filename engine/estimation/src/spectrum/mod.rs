//! The scaled columns and their eigenvalues.

mod columns;
mod directions;

pub(crate) use columns::{ScaledColumns, caller_columns, of_scaled, scaled_size};
pub(crate) use directions::{Directions, Spectrum};
