//! Values of curves and surfaces as they are written: numbers of a graph, or points of plane or
//! space.

use std::{borrow::Cow, fmt};

use serde::{
    Deserialize, Deserializer, Serialize,
    de::{SeqAccess, Visitor},
};
use utoipa::{
    PartialSchema, ToSchema,
    openapi::{
        RefOr,
        schema::{ArrayBuilder, OneOfBuilder, Schema},
    },
};

use crate::api::faults::Faults;
use flankfit_engine::geometry::space::{Dimension, Vector};
use flankfit_engine::numerics::cancel::{self, Asking};

/// `y`, `[x, y]` or `[x, y, z]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum PointBody {
    Number(f64),
    Coordinates(Vec<f64>),
}

impl PointBody {
    /// A value as it is written.
    pub fn of(dimension: Dimension, value: &Vector) -> Self {
        match dimension {
            Dimension::Graph => PointBody::Number(value.x),
            _ => PointBody::Coordinates(value.as_slice()[..dimension.count()].to_vec()),
        }
    }

    fn read(&self) -> Option<(Dimension, Vector)> {
        match self {
            PointBody::Number(y) => Some((Dimension::Graph, Vector::new(*y, 0.0, 0.0))),
            PointBody::Coordinates(point) => match point[..] {
                [x, y] => Some((Dimension::Plane, Vector::new(x, y, 0.0))),
                [x, y, z] => Some((Dimension::Space, Vector::new(x, y, z))),
                _ => None,
            },
        }
    }
}

/// Several values, which must be of one kind.
pub fn written(dimension: Dimension, values: &[Vector]) -> Vec<PointBody> {
    values.iter().map(|value| PointBody::of(dimension, value)).collect()
}

/// Reads values of one kind; each that is not is named.
pub fn read(points: &[PointBody], pointer: &str, faults: &mut Faults) -> Option<(Dimension, Vec<Vector>)> {
    read_by(points, pointer, |index| format!("{pointer}/{index}"), faults)
}

/// The same where `place` says where a value stands.
pub fn read_by(
    points: &[PointBody],
    pointer: &str,
    place: impl Fn(usize) -> String,
    faults: &mut Faults,
) -> Option<(Dimension, Vec<Vector>)> {
    let mut known = None;
    let mut values = Vec::with_capacity(points.len());
    let before = faults.count();
    for (index, point) in points.iter().enumerate().asking(20) {
        match (point.read(), known) {
            (None, _) => faults.push(place(index), "not a number, [x, y] or [x, y, z]"),
            (Some((dimension, _)), Some(first)) if dimension != first => {
                faults.push(place(index), format!("{}, where those before are {}", kind(dimension), kind(first)))
            }
            (Some((dimension, value)), _) => {
                known = Some(dimension);
                values.push(value);
            }
        }
    }
    if faults.count() > before {
        return None;
    }
    let Some(dimension) = known else {
        faults.push(pointer, "at least one value is required");
        return None;
    };
    Some((dimension, values))
}

fn kind(dimension: Dimension) -> &'static str {
    match dimension {
        Dimension::Graph => "a number",
        Dimension::Plane => "a point [x, y]",
        Dimension::Space => "a point [x, y, z]",
    }
}

impl<'de> Deserialize<'de> for PointBody {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;

        impl<'de> Visitor<'de> for Read {
            type Value = PointBody;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number, [x, y] or [x, y, z]")
            }

            fn visit_f64<E>(self, value: f64) -> Result<PointBody, E> {
                Ok(PointBody::Number(value))
            }

            fn visit_u64<E>(self, value: u64) -> Result<PointBody, E> {
                Ok(PointBody::Number(value as f64))
            }

            fn visit_i64<E>(self, value: i64) -> Result<PointBody, E> {
                Ok(PointBody::Number(value as f64))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<PointBody, A::Error> {
                let mut coordinates = Vec::with_capacity(3);
                cancel::checkpoint();
                while let Some(x) = items.next_element()? {
                    coordinates.push(x);
                }
                Ok(PointBody::Coordinates(coordinates))
            }
        }

        deserializer.deserialize_any(Read)
    }
}

impl PartialSchema for PointBody {
    fn schema() -> RefOr<Schema> {
        OneOfBuilder::new()
            .description(Some("A number of a graph, or a point: `y`, `[x, y]` or `[x, y, z]`."))
            .item(f64::schema())
            .item(ArrayBuilder::new().items(f64::schema()).min_items(Some(2)).max_items(Some(3)))
            .into()
    }
}

impl ToSchema for PointBody {
    fn name() -> Cow<'static, str> {
        "Point".into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_points_come_back_as_they_were() {
        for text in ["[1.0,-2.5]", "[[1.0,2.0],[3.0,4.0]]", "[[1.0,2.0,3.0]]"] {
            let bodies: Vec<PointBody> = serde_json::from_str(text).unwrap();
            let mut faults = Faults::default();
            let (dimension, values) = read(&bodies, "/at", &mut faults).unwrap();
            assert_eq!(serde_json::to_string(&written(dimension, &values)).unwrap(), text);
        }
    }

    #[test]
    fn what_is_of_another_kind_is_named() {
        for (text, place) in [
            ("[1,[2,3]]", "/p/1"),
            ("[[1,2],[1,2,3]]", "/p/1"),
            ("[[1]]", "/p/0"),
            ("[[1,2,3,4]]", "/p/0"),
            ("[]", "/p"),
        ] {
            let bodies: Vec<PointBody> = serde_json::from_str(text).unwrap();
            let mut faults = Faults::default();
            assert!(read(&bodies, "/p", &mut faults).is_none(), "{text}");
            assert_eq!(faults.list()[0].pointer, place, "{text}");
        }
    }
}
