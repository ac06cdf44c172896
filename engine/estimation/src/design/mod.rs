//! The measurement matrix `X` (Eqs. 13–14): which functions, under which names, on which domain,
//! and its rows at the nodes.

mod axis;
mod columns;
mod domain;
mod label;
mod measurement_matrix;
mod model;
mod place;
mod row;
mod slopes;
mod splines;
pub(super) mod tile;

pub(crate) use axis::Axis;
pub(crate) use columns::{columns, of_columns, power_of_two};
pub(crate) use domain::{Boxes, bounding_box, checked_domain, no_range};
pub(crate) use measurement_matrix::{Basis, Design, MOST_COEFFICIENTS};
pub(crate) use model::{MATRIX_TAKES_LINEAR, none_counts, product_on, too_few_nodes};
pub(crate) use place::Along;
pub(crate) use row::Row;
pub(crate) use slopes::{add_slopes, slopes};
pub(crate) use splines::{no_span, splines, within_knots};
