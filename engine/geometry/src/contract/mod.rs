//! Curves and surfaces as JSON, and in OpenAPI documents.
//!
//! A curve or surface is written with everything that is needed to build it again, and is checked
//! when it is read.

mod curve;
mod points;
mod surface;

pub use points::{Net, Point, equal_rows, points, values};
pub use surface::{Borders, Surface};
