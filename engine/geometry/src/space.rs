//! Common parts of curves and surfaces: points, the number of coordinates, and checks of control
//! points.

use nalgebra::Vector3;

use flankfit_numerics::{
    check::Faults,
    words::{Shown, counted},
};

/// A point or a derivative; coordinates above the shape's [`Dimension`] are 0.
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

/// A degree above [`HIGHEST_DEGREE`].
pub fn degree_too_high(path: &str, degree: usize) -> Faults {
    let message = format_args!("degree {degree} is above {HIGHEST_DEGREE}, the highest degree of curves and surfaces");
    Faults::one(path, message)
}

/// Weights that vanish together around the knot `place`, so that the denominator is 0 there.
pub(super) fn no_weight(place: f64) -> Faults {
    let place = Shown(place);
    let message = format_args!("the weights around parameter {place} are all 0, so no point is defined there");
    Faults::one("weights", message)
}

/// Checks control points and weights against the number that knots ask for; `place` writes an index
/// as the end of a path.
pub(super) fn check_controls(
    points: &[Vector],
    weights: Option<&[f64]>,
    wanted: usize,
    place: impl Fn(usize) -> String,
) -> Result<(), Faults> {
    if points.len() != wanted {
        let given = counted(points.len(), "control point", "control points");
        return Err(Faults::one("control_points", format_args!("{given}; knots and degree need {wanted}")));
    }
    if let Some(index) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        return Err(control_not_finite(index, &format!("control_points{}", place(index))));
    }
    let Some(weights) = weights else { return Ok(()) };
    if weights.len() != wanted {
        let (given, wanted) =
            (counted(weights.len(), "weight", "weights"), counted(wanted, "control point", "control points"));
        return Err(Faults::one("weights", format_args!("{given} for {wanted}")));
    }
    match weights.iter().position(|w| !(w.is_finite() && *w >= 0.0)) {
        Some(index) => Err(Faults::one(
            format_args!("weights{}", place(index)),
            format_args!("weight {index} ({}) is not a finite number ≥ 0", Shown(weights[index])),
        )),
        None => Ok(()),
    }
}

/// A control point with a coordinate that is NaN or infinite; in a net counted by rows.
pub(super) fn control_not_finite(index: usize, path: &str) -> Faults {
    Faults::one(path, format_args!("control point {index} is not finite"))
}

/// Places an index of a net of so many columns as row and column.
pub(super) fn in_rows(columns: usize) -> impl Fn(usize) -> String {
    move |index| format!("[{}][{}]", index / columns.max(1), index % columns.max(1))
}
