//! Checks of the numbers and points that curves are made of.

use crate::space::Vector;
use flankfit_numerics::{
    check::Faults,
    words::{Shown, are},
};

/// Differences below this have no digits for the second half of a double-double, and their
/// reciprocals soon none for the first.
const LEAST_STEP: f64 = 1e-290;

/// Refuses numbers that are not finite.
pub(crate) fn finite(list: &str, values: &[f64]) -> Result<(), Faults> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(not_finite(list, index)),
        None => Ok(()),
    }
}

/// Refuses points with a coordinate that is not finite.
pub(crate) fn points(list: &str, points: &[Vector]) -> Result<(), Faults> {
    match points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        Some(index) => Err(not_finite(list, index)),
        None => Ok(()),
    }
}

/// A number or point that is not finite.
pub(crate) fn not_finite(list: &str, index: usize) -> Faults {
    Faults::one(format_args!("{list}[{index}]"), format_args!("number {index} is not finite"))
}

/// Refuses numbers that are not finite, repeated, descending, or so close that their differences
/// lose digits.
pub(crate) fn ascending(list: &str, values: &[f64]) -> Result<(), Faults> {
    finite(list, values)?;
    for (i, pair) in values.windows(2).enumerate() {
        let (before, value, index) = (pair[0], pair[1], i + 1);
        if value == before {
            return Err(repeated(list, index, i, value));
        }
        let at = format_args!("{list}[{index}]");
        if value < before {
            return Err(Faults::one(
                at,
                format_args!(
                    "number {index} ({}) lies below the one before it ({}); the order of nodes is never changed",
                    Shown(value),
                    Shown(before)
                ),
            ));
        }
        if value - before < LEAST_STEP {
            return Err(Faults::one(
                at,
                format_args!(
                    "number {index} ({}) lies no more than {} above the one before it, which is too close for double \
                        precision",
                    Shown(value),
                    Shown(value - before)
                ),
            ));
        }
    }
    Ok(())
}

/// A number that occurs twice.
pub(crate) fn repeated(list: &str, index: usize, first: usize, value: f64) -> Faults {
    Faults::one(
        format_args!("{list}[{index}]"),
        format_args!("number {index} ({}) repeats number {first}", Shown(value)),
    )
}

/// Refuses fewer entries than the method needs.
pub(crate) fn at_least(list: &str, given: usize, least: usize) -> Result<(), Faults> {
    if given >= least {
        return Ok(());
    }
    let (too_few, needed) = (are(given), are(least));
    Err(Faults::one(list, format_args!("{given} {too_few} too few: at least {least} {needed} needed")))
}

/// Refuses more entries than the method can take.
pub(crate) fn at_most(list: &str, given: usize, most: usize) -> Result<(), Faults> {
    if given <= most {
        return Ok(());
    }
    let (too_many, possible) = (are(given), are(most));
    Err(Faults::one(list, format_args!("{given} {too_many} too many: at most {most} {possible} possible")))
}

/// Refuses a list whose length does not fit the others.
pub(crate) fn count(list: &str, given: usize, wanted: usize) -> Result<(), Faults> {
    if given == wanted {
        return Ok(());
    }
    let (are_given, are_needed) = (are(given), are(wanted));
    Err(Faults::one(list, format_args!("{given} {are_given} given where {wanted} {are_needed} needed")))
}

/// Refuses a degree that the method does not have.
pub(crate) fn degree(path: &str, degree: usize, least: usize, most: usize) -> Result<(), Faults> {
    if (least..=most).contains(&degree) {
        return Ok(());
    }
    Err(Faults::one(path, format_args!("degree {degree} is not within {least} to {most}")))
}

/// Refuses fewer nodes than the degree asks for.
pub(crate) fn nodes_of_degree(path: &str, degree: usize, nodes: usize, least: usize) -> Result<(), Faults> {
    if nodes >= least {
        return Ok(());
    }
    Err(Faults::one(path, format_args!("degree {degree} needs at least {least} nodes, {nodes} are given")))
}

/// More derivatives at a node than are allowed.
pub(crate) fn too_many_derivatives(node: usize, given: usize, most: usize) -> Faults {
    Faults::one(
        format_args!("method.derivatives[{node}]"),
        format_args!("{given} derivatives are given at node {node}, more than {most}"),
    )
}

/// A coefficient outside the range of a double.
pub(crate) fn not_representable(index: usize) -> Faults {
    Faults::one("", format_args!("coefficient {index} of the curve exceeds the range of double precision"))
}

/// Equations that are singular in double-double precision.
pub(crate) fn singular(unknown: usize) -> Faults {
    Faults::one("", format_args!("the equations of the curve are singular at unknown {unknown}"))
}

/// A place outside of the domain.
pub(crate) fn out_of_domain(value: f64, low: f64, high: f64) -> Faults {
    Faults::one(
        "",
        format_args!("the place {} is not within the domain [{}, {}]", Shown(value), Shown(low), Shown(high)),
    )
}
