//! Curves and surfaces *near* points: what a fit of B-splines or NURBS looks like as a shape.
//!
//! | what | where |
//! |---|---|
//! | the shape of a fit of the service | [`shape_of`] |

mod shape;

pub use shape::{Shape, shape_of};
