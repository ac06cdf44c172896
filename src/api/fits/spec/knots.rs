//! Knots and weights of splines: one array for a curve, arrays of arrays for a surface.

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize,
    de::{self, SeqAccess, Visitor},
};

use crate::api::json::union_schema::{documented, list};

/// Full knot vectors, ascending: one for a curve, `[knots of u, knots of v]` for a surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum KnotsBody {
    Curve(Vec<f64>),
    Surface([Vec<f64>; 2]),
}

/// Weights of control points: numbers for a curve, rows of numbers for a surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum WeightsBody {
    Curve(Vec<f64>),
    Surface(Vec<Vec<f64>>),
}

documented!(
    KnotsBody,
    "Knots",
    "Full knot vectors, ascending: one for a curve, `[knots of u, knots of v]` for a surface.",
    list(f64::schema(), None),
    list(list(f64::schema(), None), Some((2, 2))),
);
documented!(
    WeightsBody,
    "Weights",
    "Weights of control points: numbers for a curve, rows of numbers for a surface.",
    list(f64::schema(), None),
    list(list(f64::schema(), None), None),
);

/// An entry of `knots`, by which the two forms are distinguished.
enum KnotEntry {
    Number(f64),
    List(Vec<f64>),
}

impl<'de> Deserialize<'de> for KnotEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;

        impl<'de> Visitor<'de> for Read {
            type Value = KnotEntry;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number or an array of numbers")
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> Result<KnotEntry, E> {
                Ok(KnotEntry::Number(value))
            }

            fn visit_u64<E: de::Error>(self, value: u64) -> Result<KnotEntry, E> {
                Ok(KnotEntry::Number(value as f64))
            }

            fn visit_i64<E: de::Error>(self, value: i64) -> Result<KnotEntry, E> {
                Ok(KnotEntry::Number(value as f64))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<KnotEntry, A::Error> {
                let mut list = Vec::new();
                while let Some(value) = entries.next_element()? {
                    list.push(value);
                }
                Ok(KnotEntry::List(list))
            }
        }

        deserializer.deserialize_any(Read)
    }
}

impl<'de> Deserialize<'de> for KnotsBody {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;

        impl<'de> Visitor<'de> for Read {
            type Value = KnotsBody;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an array of numbers (curve) or two arrays of numbers (surface)")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<KnotsBody, A::Error> {
                match entries.next_element()? {
                    None => Ok(KnotsBody::Curve(Vec::new())),
                    Some(KnotEntry::Number(first)) => {
                        let mut knots = vec![first];
                        while let Some(knot) = entries.next_element()? {
                            knots.push(knot);
                        }
                        Ok(KnotsBody::Curve(knots))
                    }
                    Some(KnotEntry::List(u)) => {
                        let v = entries.next_element()?.ok_or_else(|| de::Error::invalid_length(1, &self))?;
                        if entries.next_element::<de::IgnoredAny>()?.is_some() {
                            return Err(de::Error::invalid_length(3, &self));
                        }
                        Ok(KnotsBody::Surface([u, v]))
                    }
                }
            }
        }

        deserializer.deserialize_seq(Read)
    }
}

/// Numbers, or rows of numbers.
pub(super) enum NumbersOrRows {
    Numbers(Vec<f64>),
    Rows(Vec<Vec<f64>>),
}

/// Reads either; the first entry says which.
pub(super) fn numbers_or_rows<'de, D: Deserializer<'de>>(
    deserializer: D,
    expected: &'static str,
) -> Result<NumbersOrRows, D::Error> {
    struct Read(&'static str);

    impl<'de> Visitor<'de> for Read {
        type Value = NumbersOrRows;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str(self.0)
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<NumbersOrRows, A::Error> {
            match entries.next_element()? {
                None => Ok(NumbersOrRows::Numbers(Vec::new())),
                Some(KnotEntry::Number(first)) => {
                    let mut numbers = vec![first];
                    while let Some(number) = entries.next_element()? {
                        numbers.push(number);
                    }
                    Ok(NumbersOrRows::Numbers(numbers))
                }
                Some(KnotEntry::List(first)) => {
                    let mut rows = vec![first];
                    while let Some(row) = entries.next_element()? {
                        rows.push(row);
                    }
                    Ok(NumbersOrRows::Rows(rows))
                }
            }
        }
    }

    deserializer.deserialize_seq(Read(expected))
}

impl<'de> Deserialize<'de> for WeightsBody {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match numbers_or_rows(deserializer, "an array of numbers (curve) or rows of numbers (surface)")? {
            NumbersOrRows::Numbers(weights) => WeightsBody::Curve(weights),
            NumbersOrRows::Rows(rows) => WeightsBody::Surface(rows),
        })
    }
}
