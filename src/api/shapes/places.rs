//! Parameters at which a curve or surface is evaluated, and results outside the range of double.

use serde::{Deserialize, Serialize, Serializer, ser::Error};

use crate::api::{faults::Faults, problem::Problem};
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

/// Numbers, or points of `width` coordinates end to end. They are written only if all are finite.
#[derive(Debug, Deserialize)]
#[serde(from = "Written")]
pub struct Values {
    pub width: usize,
    pub flat: Vec<f64>,
}

impl Values {
    /// Takes the first coordinates of points.
    pub fn new(width: usize, points: impl Iterator<Item = Vector>) -> Self {
        let mut flat = Vec::with_capacity(points.size_hint().0 * width);
        points.asking(20).for_each(|point| flat.extend_from_slice(&point.as_slice()[..width]));
        Values { width, flat }
    }
}

/// Values as they are written.
#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    Numbers(Vec<f64>),
    Points(Vec<Vec<f64>>),
}

impl From<Written> for Values {
    fn from(written: Written) -> Self {
        match written {
            Written::Numbers(flat) => flat.into(),
            Written::Points(points) => Values { width: points.first().map_or(1, Vec::len), flat: points.concat() },
        }
    }
}

impl From<Vec<f64>> for Values {
    fn from(flat: Vec<f64>) -> Self {
        Values { width: 1, flat }
    }
}

impl Serialize for Values {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.width {
            _ if !self.flat.iter().all(|x| x.is_finite()) => Err(S::Error::custom("a number is not finite")),
            1 => serializer.collect_seq(self.flat.iter().asking(20)),
            width => serializer.collect_seq(self.flat.chunks_exact(width).asking(20)),
        }
    }
}
