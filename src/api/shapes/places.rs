//! Parameters at which a curve or surface is evaluated, and results outside the range of double.

use crate::api::{faults::Faults, json::writer::Object, problem::Problem};
use flankfit_engine::{geometry::space::Vector, numerics::cancel::Asking, words::Shown};

/// Refuses what lies outside of a domain, each by the pointer that `pointer` writes of its index.
pub fn within(
    values: impl IntoIterator<Item = (usize, f64)>,
    [low, high]: [f64; 2],
    pointer: impl Fn(usize) -> String,
    faults: &mut Faults,
) {
    for (index, value) in values.into_iter().asking(20) {
        if !(low <= value && value <= high) {
            faults.push(
                pointer(index),
                format!("{} is not within the domain [{}, {}]", Shown(value), Shown(low), Shown(high)),
            );
        }
    }
}

/// The fault of numbers that leave the range of doubles on the way.
pub fn out_of_range(pointer: &str) -> Problem {
    Problem::invalid(Faults::one(
        pointer,
        "values or derivatives there exceed the range of double precision: choose another unit",
    ))
}

/// Points of `width` coordinates.
pub fn write_points(
    object: &mut Object<'_>,
    name: &'static str,
    width: usize,
    points: impl ExactSizeIterator<Item = Vector>,
) {
    let mut flat = Vec::with_capacity(points.len() * width);
    for point in points.into_iter().asking(20) {
        flat.extend_from_slice(&point.as_slice()[..width]);
    }
    object.values(name, width, &flat);
}
