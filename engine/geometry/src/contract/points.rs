//! Numbers of a graph, or points of plane or space.

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize,
    de::{Error, SeqAccess, Visitor},
};

use crate::space::{Dimension, Vector};
use flankfit_numerics::{
    cancel::{self, Asking},
    check::Faults,
    contract::{list, number},
    words::counted,
};

/// `y`, `[x, y]` or `[x, y, z]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Point {
    /// A number of a graph.
    Number(f64),
    /// A point of the plane.
    Plane([f64; 2]),
    /// A point of space.
    Space([f64; 3]),
}

impl Point {
    /// Returns a value of a curve or surface in its written form.
    pub fn new(dimension: Dimension, value: &Vector) -> Self {
        match dimension {
            Dimension::Graph => Point::Number(value.x),
            Dimension::Plane => Point::Plane([value.x, value.y]),
            Dimension::Space => Point::Space([value.x, value.y, value.z]),
        }
    }

    fn value(self) -> (Dimension, Vector) {
        match self {
            Point::Number(y) => (Dimension::Graph, Vector::new(y, 0.0, 0.0)),
            Point::Plane([x, y]) => (Dimension::Plane, Vector::new(x, y, 0.0)),
            Point::Space(point) => (Dimension::Space, point.into()),
        }
    }
}

/// Returns values of one dimension in their written form.
pub fn points(dimension: Dimension, values: &[Vector]) -> Vec<Point> {
    values.iter().map(|value| Point::new(dimension, value)).collect()
}

/// Returns the dimension and the values of points, at least one, if all are of one kind; otherwise
/// adds an error for each that is not. `path` is the place of the points.
pub fn values(points: &[Point], path: &str, faults: &mut Faults) -> Option<(Dimension, Vec<Vector>)> {
    of_one_kind(points, path, |index| format!("{path}[{index}]"), faults)
}

fn of_one_kind(
    points: &[Point],
    path: &str,
    place: impl Fn(usize) -> String,
    faults: &mut Faults,
) -> Option<(Dimension, Vec<Vector>)> {
    let Some((dimension, _)) = points.first().map(|point| point.value()) else {
        faults.push(path, "at least one value is required");
        return None;
    };
    let mut values = Vec::with_capacity(points.len());
    for (index, point) in points.iter().enumerate().asking(20) {
        match point.value() {
            (own, value) if own == dimension => values.push(value),
            (own, _) => {
                faults.push(place(index), format_args!("{}, where those before are {}", kind(own), kind(dimension)))
            }
        }
    }
    (values.len() == points.len()).then_some((dimension, values))
}

fn kind(dimension: Dimension) -> &'static str {
    match dimension {
        Dimension::Graph => "a number",
        Dimension::Plane => "a point [x, y]",
        Dimension::Space => "a point [x, y, z]",
    }
}

impl<'de> Deserialize<'de> for Point {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;

        impl<'de> Visitor<'de> for Read {
            type Value = Point;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number, [x, y] or [x, y, z]")
            }

            fn visit_f64<E>(self, value: f64) -> Result<Point, E> {
                Ok(Point::Number(value))
            }

            fn visit_u64<E>(self, value: u64) -> Result<Point, E> {
                Ok(Point::Number(value as f64))
            }

            fn visit_i64<E>(self, value: i64) -> Result<Point, E> {
                Ok(Point::Number(value as f64))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Point, A::Error> {
                cancel::checkpoint();
                match (items.next_element()?, items.next_element()?, items.next_element()?) {
                    (Some(x), Some(y), None) => Ok(Point::Plane([x, y])),
                    (Some(x), Some(y), Some(z)) => Ok(Point::Space([x, y, z])),
                    (first, ..) => Err(A::Error::invalid_length(usize::from(first.is_some()), &self)),
                }
            }
        }

        deserializer.deserialize_any(Read)
    }
}

flankfit_numerics::alternatives!(
    Point,
    "A number of a graph, or a point: `y`, `[x, y]` or `[x, y, z]`.",
    number(),
    list(number(), Some((2, 3))),
);

/// Values of one dimension in rows of one length: v running fastest, a row for each index along u.
#[derive(Clone, Debug, PartialEq)]
pub struct Net {
    /// Number of coordinates.
    pub dimension: Dimension,
    /// Number of rows, at least 1.
    pub rows: usize,
    /// Number of values in a row, at least 1.
    pub columns: usize,
    /// The rows, one after the other.
    pub values: Vec<Vector>,
}

impl Net {
    /// Returns the net of rows of points, or adds what is wrong with them; `path` is their place.
    pub fn new(rows: &[Vec<Point>], path: &str, faults: &mut Faults) -> Option<Self> {
        let columns = equal_rows(rows, path, faults)?;
        let place = |index| format!("{path}[{}][{}]", index / columns, index % columns);
        let (dimension, values) = of_one_kind(&rows.concat(), path, place, faults)?;
        Some(Net { dimension, rows: rows.len(), columns, values })
    }

    /// Returns values in their written form, in rows of `columns`.
    pub fn points(dimension: Dimension, columns: usize, values: &[Vector]) -> Vec<Vec<Point>> {
        values.chunks(columns.max(1)).map(|row| points(dimension, row)).collect()
    }
}

/// Returns the length of all rows, which is at least 1, or adds an error for each row of another
/// length.
pub fn equal_rows<T>(rows: &[Vec<T>], path: &str, faults: &mut Faults) -> Option<usize> {
    let columns = rows.first().map_or(0, Vec::len);
    if columns == 0 {
        faults.push(path, "at least one row with at least one value is required");
        return None;
    }
    let before = faults.count();
    for (i, row) in rows.iter().enumerate().filter(|(_, row)| row.len() != columns) {
        let given = counted(row.len(), "value", "values");
        faults.push(format_args!("{path}[{i}]"), format_args!("{given}, where the first row has {columns}"));
    }
    (faults.count() == before).then_some(columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_points_are_written_as_they_were_read() {
        for text in ["[1.0,-2.5]", "[[1.0,2.0],[3.0,4.0]]", "[[1.0,2.0,3.0]]"] {
            let read: Vec<Point> = serde_json::from_str(text).unwrap();
            let (dimension, values) = values(&read, "at", &mut Faults::default()).unwrap();
            assert_eq!(serde_json::to_string(&points(dimension, &values)).unwrap(), text);
        }
    }
}
