//! Points that a curve is to pass near, and where in a request for one its faults are found.

use super::{
    fault::{CurveFaults, CurveField},
    reason::NearReason,
};
use crate::fault::{Faults, Field, NodeList};
use flankfit_geometry::curve::{
    fault::{CurveFault, Part},
    parametrization::Parametrization,
};

/// Points and where on the curve they belong.
#[derive(Clone, Copy, Debug)]
pub struct CurvePoints<'a> {
    /// y alone, or x and y, or x, y and z.
    pub coordinates: &'a [Vec<f64>],
    /// Where on the curve each point belongs.
    pub parameters: Parameters<'a>,
    /// Ω of least squares; 0 leaves a point out.
    pub weight: Option<&'a [f64]>,
}

/// The parameter of every point.
#[derive(Clone, Copy, Debug)]
pub enum Parameters<'a> {
    /// x of a graph, or parameters of points; in any order but for averaged knots.
    Given(&'a [f64]),
    /// From the points themselves; not for graphs.
    By(Parametrization),
}

impl CurvePoints<'_> {
    /// Points of weight 0 say nothing.
    pub fn counts(&self, k: usize) -> bool {
        self.weight.is_none_or(|weight| weight.get(k).is_none_or(|w| *w > 0.0))
    }
}

/// Coordinate `c` of point `k`; without a coordinate its parameter.
pub(super) fn place(points: &CurvePoints, k: usize, c: Option<usize>) -> CurveField {
    match (points.coordinates.len(), c, points.parameters) {
        (1, None, _) => CurveField::Abscissa(k),
        (1, Some(_), _) => CurveField::Ordinate(k),
        (_, None, Parameters::Given(_)) => CurveField::Parameter(k),
        (_, None, Parameters::By(_)) => CurveField::Point(k),
        (_, Some(c), _) => CurveField::Coordinate(k, c),
    }
}

/// What the geometry of curves refused, as faults of the points.
pub(super) fn curve_fault(points: &CurvePoints, fault: &CurveFault) -> CurveFaults {
    let field = match (fault.part(), fault.indices().first().copied()) {
        (Some(Part::Controls), _) => CurveField::ControlCount,
        (Some(Part::Degree), _) => Field::Degree.into(),
        (_, Some(k)) => place(points, k, None),
        (_, None) => CurveField::Points,
    };
    CurveFaults::one(field, NearReason::from(fault.clone()))
}

/// Faults of the fit of a coordinate, as those of the curve.
pub(super) fn translated(points: &CurvePoints, faults: Faults) -> CurveFaults {
    faults.placed(|field| match field {
        Field::Entry(NodeList::X, k) => place(points, k, None),
        Field::Entry(NodeList::Weight, k) => CurveField::Weight(k),
        field if field.is_of_nodes() => CurveField::Points,
        field => CurveField::Fit(field),
    })
}
