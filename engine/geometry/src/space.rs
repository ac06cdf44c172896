//! Common parts of curves and surfaces: points, the number of coordinates, and reasons for refusing
//! a shape.

use nalgebra::Vector3;

use flankfit_numerics::fault::words::{Shown, counted};

/// A point or a derivative; coordinates beyond the shape's [`Dimension`] are 0.
pub type Vector = Vector3<f64>;

/// The highest degree of a B-spline or Bézier curve or surface. More neither an eye nor a machine
/// could follow.
pub const HIGHEST_DEGREE: usize = 25;

/// How many coordinates the values of a shape have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Dimension {
    /// One number over the parameters: y(x) or z(u, v). Its place in space has the parameters as
    /// further coordinates.
    Graph = 1,
    /// Points (x, y).
    Plane = 2,
    /// Points (x, y, z).
    Space = 3,
}

impl Dimension {
    /// The dimension of points with `count` coordinates.
    pub fn of(count: usize) -> Option<Self> {
        match count {
            1 => Some(Dimension::Graph),
            2 => Some(Dimension::Plane),
            3 => Some(Dimension::Space),
            _ => None,
        }
    }

    /// How many coordinates count.
    pub fn count(self) -> usize {
        self as usize
    }

    /// Whether the values are points rather than numbers over the parameters.
    pub fn is_parametric(self) -> bool {
        self != Dimension::Graph
    }
}

/// Why control points and weights are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ControlFault {
    /// A degree above [`HIGHEST_DEGREE`].
    #[error("degree {degree} is above {HIGHEST_DEGREE}, the highest that curves and surfaces have here")]
    Degree {
        /// Degree asked for.
        degree: usize,
    },
    /// Control points that are not as many as knots and degree ask for.
    #[error("{}; knots and degree ask for {wanted}", counted(*.given, "control point", "control points"))]
    Count {
        /// Control points given.
        given: usize,
        /// Control points that knots and degree ask for.
        wanted: usize,
    },
    /// A control point with a coordinate that is NaN or infinite.
    #[error("control point {index} is not finite")]
    NotFinite {
        /// Its index, from 0; in a net counted by rows.
        index: usize,
    },
    /// Weights that are not one for each control point.
    #[error("{} for {}", counted(*.given, "weight", "weights"), counted(*.wanted, "control point", "control points"))]
    WeightCount {
        /// Weights given.
        given: usize,
        /// Control points, each of which needs one.
        wanted: usize,
    },
    /// A weight below 0, NaN or infinite.
    #[error("weight {index} ({value}) is not a finite number ≥ 0", value = Shown(*.value))]
    Weight {
        /// Its index, from 0; in a net counted by rows.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// Weights that vanish together, so that the denominator is 0 at a place.
    #[error(
        "the weights around parameter {place} are all 0, so that no point is defined there",
        place = Shown(*.place)
    )]
    NoWeight {
        /// The place: a knot.
        place: f64,
    },
}

impl ControlFault {
    /// Which control point or weight is at fault, where it is one.
    pub fn index(&self) -> Option<usize> {
        match self {
            ControlFault::NotFinite { index } | ControlFault::Weight { index, .. } => Some(*index),
            _ => None,
        }
    }
}

/// Checks control points and weights against the number that knots ask for.
pub(super) fn check_controls(points: &[Vector], weights: Option<&[f64]>, wanted: usize) -> Result<(), ControlFault> {
    if points.len() != wanted {
        return Err(ControlFault::Count { given: points.len(), wanted });
    }
    if let Some(index) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        return Err(ControlFault::NotFinite { index });
    }
    let Some(weights) = weights else { return Ok(()) };
    if weights.len() != wanted {
        return Err(ControlFault::WeightCount { given: weights.len(), wanted });
    }
    match weights.iter().position(|w| !(w.is_finite() && *w >= 0.0)) {
        Some(index) => Err(ControlFault::Weight { index, value: weights[index] }),
        None => Ok(()),
    }
}
