//! Curves and surfaces *near* points: the shape of a fit of B-splines or NURBS, and fits in
//! addition to [`super::fit()`].
//!
//! | what | where |
//! |---|---|
//! | the shape of any fit of B-splines or polynomials | [`shape_of`] |
//! | curves y(x), or of plane or space, knots given or placed | [`curve`] |
//! | smoothing splines | [`super::smoothing`] |
//! | big scattered surfaces, of one or three coordinates | [`surface`] |

mod adaptive;
mod curve;
mod points;
mod settings;
mod shape;
mod surface;
mod surface_report;
mod swing;
mod trial;

pub use crate::result::Shape;
pub use adaptive::{Step, Stop};
pub use curve::{CurveFit, curve};
pub use points::{CurvePoints, Parameters};
pub(super) use settings::POSITIONS_EXACT;
pub use settings::{Adaptive, CurveSettings, KnotPlacement};
pub use shape::shape_of;
pub use surface::{Coordinate, SurfaceFit, SurfaceInclude, SurfacePoints, Weight, surface};
pub use swing::WILD;
