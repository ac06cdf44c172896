//! Faults of knots and control points with their places in the request.

use crate::api::faults::Faults;
use flankfit_engine::geometry::{
    KnotFault,
    curve::{CurveFault, Part},
    space::ControlFault,
};

/// What the request calls abscissae and values.
pub struct CurveFields {
    pub x: &'static str,
    pub values: &'static str,
}

/// A fault of the knot vector at `at`.
pub fn knot_fault(fault: &KnotFault, at: &str, faults: &mut Faults) {
    match fault.index() {
        Some(index) => faults.push(format!("{at}/{index}"), fault.to_string()),
        None => faults.push(at, fault.to_string()),
    }
}

/// A fault of control points or weights of the shape at `at`; `place` writes an index as the end of
/// a pointer.
pub fn control_fault(fault: &ControlFault, at: &str, place: impl Fn(usize) -> String, faults: &mut Faults) {
    let pointer = match fault {
        ControlFault::Degree { .. } => format!("{at}/degree"),
        ControlFault::Count { .. } => format!("{at}/control_points"),
        ControlFault::NotFinite { index } => format!("{at}/control_points/{}", place(*index)),
        ControlFault::WeightCount { .. } | ControlFault::NoWeight { .. } => format!("{at}/weights"),
        ControlFault::Weight { index, .. } => format!("{at}/weights/{}", place(*index)),
    };
    faults.push(pointer, fault.to_string());
}

/// A fault of the curve at `at` that is made of what `fields` names.
pub fn curve_fault(fault: &CurveFault, at: &str, fields: &CurveFields, faults: &mut Faults) {
    if let CurveFault::Controls(fault) = fault {
        return control_fault(fault, at, |index| index.to_string(), faults);
    }
    let mut pointer = at.to_owned();
    if let Some(part) = fault.part() {
        pointer.push('/');
        pointer.push_str(match part {
            Part::X => fields.x,
            Part::Y | Part::Points => fields.values,
            Part::Tangents => "method/values",
            Part::Derivatives => "method/derivatives",
            Part::Start => "method/ends/start",
            Part::End => "method/ends/end",
            Part::Knots => "method/knots",
            Part::Controls => "control_points",
            Part::Degree => "method/degree",
        });
    }
    for index in fault.indices() {
        pointer.push_str(&format!("/{index}"));
    }
    faults.push(pointer, fault.to_string());
}
