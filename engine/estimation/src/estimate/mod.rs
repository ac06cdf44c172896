//! Estimates from the spectrum: plain least squares (Eq. 15) and the filtered one (Eq. 29).

mod columns;
mod filtered;
mod least_squares;
mod plain;

pub(crate) use columns::Frame;
pub(crate) use filtered::{Estimate, directions, residuals};
pub(crate) use least_squares::LeastSquares;
pub(crate) use plain::PlainEstimate;
