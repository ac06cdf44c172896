//! Which part of a request for a curve near points is at fault.

use crate::{
    error::Refused,
    fault::{Field, Reason},
};
use flankfit_numerics::fault::Faults;

/// A part of what is asked for; indices count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveField {
    /// The points.
    Points,
    /// How their parameters are found.
    Parametrization,
    /// The abscissa of a point of a graph.
    Abscissa(usize),
    /// The ordinate of a point of a graph.
    Ordinate(usize),
    /// A parameter that is given.
    Parameter(usize),
    /// A point of plane or space.
    Point(usize),
    /// A coordinate of a point of plane or space.
    Coordinate(usize, usize),
    /// The curve asked for.
    Curve,
    /// Weights of the points.
    Weights,
    /// One of them.
    Weight(usize),
    /// The number of control points.
    ControlCount,
    /// The largest deviation, where knots are placed by it.
    Tolerance,
    /// The most control points, where knots are placed.
    MostControls,
    /// A part that the curve has in common with every fit: its model, and what is beside it.
    Fit(Field),
}

impl From<Field> for CurveField {
    fn from(field: Field) -> Self {
        CurveField::Fit(field)
    }
}

/// Faults of a curve near points.
pub type CurveFaults = Faults<CurveField, Reason>;

/// Why there is no curve near the points.
pub type CurveRefused = Refused<CurveField, Reason>;
