//! Faults of knots and control points with their places in the request.

use crate::api::{faults::Faults, problem::Problem};
use flankfit_engine::{
    estimation::FitError,
    geometry::{
        KnotFault,
        curve::{CurveFault, Part},
        space::ControlFault,
    },
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

/// Faults of a fit by their places in a request whose method is the model and whose nodes stand at
/// `base`.
pub fn moved(faults: &Faults, base: &str) -> Faults {
    faults.moved(|pointer| moved_pointer(pointer, base))
}

fn moved_pointer(pointer: &str, base: &str) -> String {
    match (pointer.strip_prefix("/model"), pointer.strip_prefix("/nodes")) {
        (Some(rest), _) => format!("/method{rest}"),
        (_, Some(rest)) => format!("{base}{rest}"),
        _ => pointer.to_owned(),
    }
}

/// A fit that was refused, in the same way.
pub fn refused_fit(error: FitError, base: &str) -> Problem {
    Problem::of_fit(error, |pointer| moved_pointer(pointer, base))
}
