//! Checks of nodes, knots and borders of a surface; axis 0 is u, 1 is v.

use super::Border;
use crate::space::Dimension;
use flankfit_numerics::{
    check::{Fault, Faults},
    words::{Shown, counted},
};

/// Names of the axes.
pub(super) const AXES: [&str; 2] = ["u", "v"];

/// Refuses fewer nodes along an axis than are needed.
pub(super) fn at_least(axis: usize, given: usize, least: usize) -> Result<(), Faults> {
    if given >= least { Ok(()) } else { Err(too_few(axis, given, least)) }
}

/// Fewer nodes along an axis than are needed.
pub(super) fn too_few(axis: usize, given: usize, least: usize) -> Faults {
    let (given, name) = (counted(given, "node", "nodes"), AXES[axis]);
    let message = format_args!("{given} along {name}; at least {least} are needed");
    Faults::one(format_args!("nodes.{name}"), message)
}

/// Refuses places on an axis that are not finite or do not ascend.
pub(super) fn ascending(axis: usize, places: &[f64]) -> Result<(), Faults> {
    let name = AXES[axis];
    if let Some(index) = places.iter().position(|x| !x.is_finite()) {
        return Err(along_at(axis, index, format_args!("{name} number {index} is not finite")));
    }
    match places.windows(2).position(|pair| !(pair[0] < pair[1])) {
        Some(i) => {
            let (index, value, before) = (i + 1, Shown(places[i + 1]), Shown(places[i]));
            let message =
                format_args!("{name} number {index} ({value}) does not lie above the one before it ({before})");
            Err(along_at(axis, index, message))
        }
        None => Ok(()),
    }
}

fn along_at(axis: usize, index: usize, message: impl std::fmt::Display) -> Faults {
    Faults::one(format_args!("nodes.{}[{index}]", AXES[axis]), message)
}

/// Refuses rows of unequal length.
pub(super) fn even_rows(lengths: impl IntoIterator<Item = usize>, wanted: usize) -> Result<(), Faults> {
    match lengths.into_iter().enumerate().find(|(_, given)| *given != wanted) {
        Some((row, given)) => {
            let given = counted(given, "point", "points");
            let message = format_args!("row {row} has {given}, the first one {wanted}");
            Err(Faults::one(format_args!("nodes.z[{row}]"), message))
        }
        None => Ok(()),
    }
}

/// A degree along an axis that is not from 1 to `most`.
pub(super) fn degree(axis: usize, degree: usize, most: usize) -> Faults {
    let message = format_args!("degree {degree} along {} is not within 1 to {most}", AXES[axis]);
    Faults::one(format_args!("degree[{axis}]"), message)
}

/// More spans than the nodes determine.
pub(super) fn spans(axis: usize, spans: usize, nodes: usize, degree: usize) -> Faults {
    let name = AXES[axis];
    let message = format_args!(
        "{spans} spans along {name} need more functions than the {nodes} nodes there determine at degree {degree}"
    );
    Faults::one(format_args!("spans[{axis}]"), message)
}

/// Places errors of a knot vector among those of both axes.
pub(super) fn knots(axis: usize) -> impl Fn(Faults) -> Faults {
    move |faults| {
        let located = faults
            .map(|Fault { path, message }| Fault { path, message: format!("knots along {}: {message}", AXES[axis]) });
        located.within(&format!("knots[{axis}]"))
    }
}

/// More basis functions than nodes along an axis, or another number of them.
pub(super) fn functions(axis: usize, functions: usize, nodes: usize) -> Faults {
    let message = format_args!("{functions} functions along {} for {nodes} nodes", AXES[axis]);
    Faults::one(format_args!("knots[{axis}]"), message)
}

/// A place on an axis that is not within the domain of the knots.
pub(super) fn out_of_domain(axis: usize, index: usize, value: f64, [low, high]: [f64; 2]) -> Faults {
    let (name, [value, low, high]) = (AXES[axis], [value, low, high].map(Shown));
    let message =
        format_args!("node {index} along {name} ({value}) lies outside of the knots' domain, [{low}, {high}]");
    along_at(axis, index, message)
}

/// A basis function without a node of its own in its support.
pub(super) fn no_node(axis: usize, function: usize, support: [f64; 2]) -> Faults {
    let (name, [low, high]) = (AXES[axis], support.map(Shown));
    let message = format_args!(
        "no node along {name} is left for function {function}, which is non-zero between knots {low} and {high} (the \
         condition of Schoenberg and Whitney)"
    );
    Faults::one(format_args!("knots[{axis}][{function}]"), message)
}

/// A basis function that the nodes determine no better than rounding.
pub(super) fn undetermined(axis: usize, function: usize, support: [f64; 2]) -> Faults {
    let (name, [low, high]) = (AXES[axis], support.map(Shown));
    let message = format_args!(
        "the nodes along {name} determine function {function}, which is non-zero between knots {low} and {high}, only \
         to rounding"
    );
    Faults::one(format_args!("knots[{axis}][{function}]"), message)
}

/// A control point outside the range of a double; counted by rows.
pub(super) fn not_representable(index: usize) -> Faults {
    Faults::one("nodes.z", format_args!("control point {index} exceeds the range of double precision"))
}

/// A domain without width along an axis.
pub(super) fn no_width(axis: usize, [low, high]: [f64; 2]) -> Faults {
    let message = format_args!("the domain [{}, {}] has no width", Shown(low), Shown(high));
    Faults::one(format_args!("domain[{axis}]"), message)
}

/// A border with values of another dimension than the first one.
pub(super) fn border_dimension(border: Border, given: Dimension) -> Faults {
    let (given, like) = (given.count(), Border::U0);
    Faults::one(
        format_args!("boundaries.{border}"),
        format_args!(
            "border {border} has values of {given} coordinates; heights (1) or points of space (3) are needed, as on \
             {like}"
        ),
    )
}

/// More borders missing than the tip of a three-sided patch accounts for.
pub(super) fn border_missing(border: Border) -> Faults {
    Faults::one(
        format_args!("boundaries.{border}"),
        format_args!(
            "border {border} is missing; only one of the four may be missing, for a patch in space with three sides"
        ),
    )
}

/// A cross derivative that does not agree with the border that runs along it at a corner.
pub(super) fn cross_off(border: Border, [i, j]: [usize; 2], gap: f64, tolerance: f64) -> Faults {
    let [gap, tolerance] = [gap, tolerance].map(Shown);
    Faults::one(
        format_args!("cross_derivatives.{border}"),
        format_args!(
            "at the corner of u{i} and v{j} the cross derivative of {border} is {gap} off the border that runs \
             there, more than {tolerance}"
        ),
    )
}

/// A twist vector that is NaN or infinite.
pub(super) fn twist_not_finite([i, j]: [usize; 2]) -> Faults {
    Faults::one(format_args!("twists[{i}][{j}]"), format_args!("twist ({i}, {j}) is not finite"))
}

/// Refuses a tolerance that is negative or not finite.
pub(super) fn tolerance(tolerance: f64) -> Result<(), Faults> {
    if tolerance >= 0.0 && tolerance.is_finite() {
        return Ok(());
    }
    let message = format_args!("a tolerance of {} is not a finite number ≥ 0", Shown(tolerance));
    Err(Faults::one("tolerance", message))
}
