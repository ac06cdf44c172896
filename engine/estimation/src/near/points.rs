//! Points that a curve is to pass near, and the paths of their errors in a request.

use flankfit_geometry::curve::Parametrization;
use flankfit_numerics::check::{Fault, Faults, rest_of};

/// Points and where on the curve they belong.
#[derive(Clone, Copy, Debug)]
pub struct CurvePoints<'a> {
    /// y alone, or x and y, or x, y and z.
    pub coordinates: &'a [Vec<f64>],
    /// Parameter of each point on the curve.
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

/// Path to coordinate `c` of point `k`.
pub(super) fn place(points: &CurvePoints, k: usize, c: usize) -> String {
    match points.coordinates.len() {
        1 => format!("points.y[{k}]"),
        _ => format!("points.xyz[{k}][{c}]"),
    }
}

/// Path of the field that gives the parameters.
fn parameters(points: &CurvePoints) -> &'static str {
    match (points.coordinates.len(), points.parameters) {
        (1, _) => "points.x",
        (_, Parameters::Given(_)) => "points.parameters",
        (_, Parameters::By(_)) => "points.xyz",
    }
}

/// Places errors of knots among the parameters and settings of the curve.
pub(super) fn of_knots(points: &CurvePoints, faults: Faults) -> Faults {
    faults.moved("nodes", parameters(points)).moved("control_points", "method.control_count")
}

/// Places errors of the parameters of points.
pub(super) fn of_parameters(points: &CurvePoints, faults: Faults) -> Faults {
    faults.map(|Fault { path, message }| Fault {
        path: if path.is_empty() { "points".to_owned() } else { format!("{}{path}", parameters(points)) },
        message,
    })
}

/// Places errors of the fit of a coordinate among those of the curve: only abscissae and weights
/// are common to all coordinates.
pub(super) fn translated(points: &CurvePoints, faults: Faults) -> Faults {
    faults.map(|Fault { path, message }| {
        let entry = |list: &str| rest_of(&path, list).filter(|rest| !rest.is_empty());
        let path = match (entry("nodes.x"), entry("nodes.weight")) {
            (Some(rest), _) => format!("{}{rest}", parameters(points)),
            (_, Some(rest)) => format!("method.weight{rest}"),
            _ if rest_of(&path, "nodes").is_some() => "points".to_owned(),
            _ => path,
        };
        Fault { path, message }
    })
}
