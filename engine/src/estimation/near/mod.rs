//! Curves and surfaces *near* points: what a fit of B-splines or NURBS looks like as a shape, and
//! fits beyond those of the service.
//!
//! | what | where |
//! |---|---|
//! | the shape of a fit of the service | [`shape_of`] |
//! | curves y(x), or of plane or space, knots given or placed | [`curve`] |
//! | smoothing splines | [`super::smoothing`] |
//! | big scattered surfaces, of one or three coordinates | [`surface`] |

mod adaptive;
mod curve;
pub mod fault;
mod shape;
mod surface;
mod surface_report;
mod swing;

pub use adaptive::{Adaptive, Step, Stop};
pub use curve::{CurveFit, CurvePoints, CurveSettings, KnotPlacement, Parameters, curve};
pub use shape::{Shape, shape_of};
pub use surface::{Coordinate, SurfaceFit, SurfaceInclude, SurfacePoints, Weight, surface};
pub use swing::WILD;
