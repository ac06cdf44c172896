//! Why a mesh of curves is refused.

use super::{GridFault, boundaries::BoundaryFault, patchwork::PatchworkFault};
use crate::curve::CurveFault;
use flankfit_numerics::fault::words::{Shown, counted};

/// Why a mesh is refused. Family 0 are the curves at given u (over v), family 1 those at given v.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshFault {
    /// The places of the curves are refused.
    #[error(transparent)]
    Lines(#[from] GridFault),
    /// Curves of a family that are not one for each of its places.
    #[error("{} for {}", counted(*.given, "curve", "curves"), counted(*.wanted, "place", "places"))]
    Count {
        /// The family: 0 for curves at given u, 1 for curves at given v.
        family: usize,
        /// Curves given.
        given: usize,
        /// Places of the family.
        wanted: usize,
    },
    /// A curve is missing that is neither the first nor the last of one family.
    #[error("the curve is missing; only the first or last of one family of points in space may be")]
    Missing {
        /// The family: 0 for curves at given u, 1 for curves at given v.
        family: usize,
        /// Index of the curve in its family, from 0.
        index: usize,
    },
    /// A curve with values of another dimension.
    #[error("the curve has values of {}, where {wanted} are wanted", counted(*.given, "coordinate", "coordinates"))]
    Dimension {
        /// The family: 0 for curves at given u, 1 for curves at given v.
        family: usize,
        /// Index of the curve in its family, from 0.
        index: usize,
        /// Coordinates of its values.
        given: usize,
        /// Coordinates of the other curves.
        wanted: usize,
    },
    /// A curve over another domain than the mesh.
    #[error(
        "the curve runs over [{}, {}], the mesh over [{}, {}]",
        Shown(*.low), Shown(*.high), Shown(*.wanted_low), Shown(*.wanted_high)
    )]
    Domain {
        /// The family: 0 for curves at given u, 1 for curves at given v.
        family: usize,
        /// Index of the curve in its family, from 0.
        index: usize,
        /// Lower end of its domain.
        low: f64,
        /// Upper end of its domain.
        high: f64,
        /// Lower end of the mesh along this axis.
        wanted_low: f64,
        /// Upper end of the mesh along this axis.
        wanted_high: f64,
    },
    /// A curve that cannot be written as a B-spline.
    #[error("the curve is no B-spline: {fault}")]
    Curve {
        /// The family: 0 for curves at given u, 1 for curves at given v.
        family: usize,
        /// Index of the curve in its family, from 0.
        index: usize,
        /// Why it cannot.
        fault: CurveFault,
    },
    /// Two curves that do not meet where they cross.
    #[error(
        "curve {i} over v and curve {j} over u are {gap} apart where they cross, more than {tolerance}",
        gap = Shown(*.gap), tolerance = Shown(*.tolerance)
    )]
    Crossing {
        /// Index of the curve over v, from 0.
        i: usize,
        /// Index of the curve over u, from 0.
        j: usize,
        /// Their distance there.
        gap: f64,
        /// Distance allowed.
        tolerance: f64,
    },
    /// A patch refused by its boundary curves.
    #[error("patch ({i}, {j}): {fault}")]
    Patch {
        /// Index of the patch along u, from 0.
        i: usize,
        /// Index of the patch along v, from 0.
        j: usize,
        /// Why it is refused.
        fault: BoundaryFault,
    },
    /// The patches do not make one surface.
    #[error(transparent)]
    Patchwork(#[from] PatchworkFault),
}
