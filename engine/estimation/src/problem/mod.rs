//! The least-squares problem after the factorisation: observations, and the residuals of any
//! coefficients.

mod linear;
mod matrix_b;
mod observations;
mod rows;
mod summary;

pub(crate) use linear::{LinearProblem, Residuals};
pub(crate) use matrix_b::{image_of_nodes, matrix_b};
pub(crate) use observations::Evidence;
pub(crate) use rows::Rows;
pub(crate) use summary::SummaryStatistics;
