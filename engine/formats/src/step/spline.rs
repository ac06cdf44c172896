//! B-spline curves and surfaces, and their rational forms as complex instances.

use super::super::{
    axis::Axis,
    cad::{CadCurve, CadSurface},
    number::real,
    text::step_string,
};
use super::{
    data::{Data, Id},
    list,
};
use flankfit_geometry::space::Vector;

pub(super) fn point(data: &mut Data, point: &Vector) -> Id {
    data.add(format!("CARTESIAN_POINT('',{})", reals(point.as_slice())))
}

/// B_SPLINE_CURVE_WITH_KNOTS, or the complex instance that has weights as well.
pub(super) fn curve(data: &mut Data, name: &str, curve: &CadCurve) -> Id {
    let name = step_string(name);
    let points: Vec<Id> = curve.points.iter().map(|p| point(data, p)).collect();
    let (knots, counts) = multiplicities(&curve.axis);
    let spline = format!("{},{},.UNSPECIFIED.,{},.F.", curve.axis.degree, list(&points), logical(curve.is_closed()));
    let knots = format!("{counts},{knots},.UNSPECIFIED.");
    data.add(match &curve.weights {
        None => format!("B_SPLINE_CURVE_WITH_KNOTS({name},{spline},{knots})"),
        Some(weights) => format!(
            "(BOUNDED_CURVE()B_SPLINE_CURVE({spline})B_SPLINE_CURVE_WITH_KNOTS({knots})CURVE()\
             GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_CURVE({})REPRESENTATION_ITEM({name}))",
            reals(weights)
        ),
    })
}

/// B_SPLINE_SURFACE_WITH_KNOTS, or the complex instance that has weights as well.
pub(super) fn surface(data: &mut Data, name: &str, surface: &CadSurface) -> Id {
    let name = step_string(name);
    let [along_u, along_v] = &surface.axes;
    let points: Vec<Id> = surface.points.iter().map(|p| point(data, p)).collect();
    let rows: Vec<String> = points.chunks(along_v.size()).map(list).collect();
    let ((u_knots, u_counts), (v_knots, v_counts)) = (multiplicities(along_u), multiplicities(along_v));
    let [closed_u, closed_v] = surface.is_closed().map(logical);
    let spline =
        format!("{},{},{},.UNSPECIFIED.,{closed_u},{closed_v},.F.", along_u.degree, along_v.degree, list(&rows));
    let knots = format!("{u_counts},{v_counts},{u_knots},{v_knots},.UNSPECIFIED.");
    data.add(match &surface.weights {
        None => format!("B_SPLINE_SURFACE_WITH_KNOTS({name},{spline},{knots})"),
        Some(weights) => {
            let rows: Vec<String> = weights.chunks(along_v.size()).map(reals).collect();
            format!(
                "(BOUNDED_SURFACE()B_SPLINE_SURFACE({spline})B_SPLINE_SURFACE_WITH_KNOTS({knots})\
                 GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_SURFACE({})REPRESENTATION_ITEM({name})SURFACE())",
                list(&rows)
            )
        }
    })
}

fn multiplicities(axis: &Axis) -> (String, String) {
    let (knots, counts) = axis.multiplicities();
    (reals(&knots), list(&counts))
}

fn reals(numbers: &[f64]) -> String {
    list(&numbers.iter().map(|x| real(*x)).collect::<Vec<_>>())
}

pub(super) fn logical(value: bool) -> &'static str {
    if value { ".T." } else { ".F." }
}
