//! Planes.

use crate::space::Vector;

/// All points with `normal · x = offset`; the normal has length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal.
    pub normal: Vector,
    /// Distance from the origin along the normal.
    pub offset: f64,
}
