//! The curve or surface that a fit is.

use flankfit_geometry::{curve::CurveShape, surface::SurfaceShape};

/// A fitted curve or surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// The graph y(x), or a curve of plane or space.
    Curve(CurveShape),
    /// The graph z(u, v), or a surface in space.
    Surface(SurfaceShape),
}
