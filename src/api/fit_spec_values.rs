//! Values of a spec that take one of two forms: `3 | [p, q]`, `"auto" | L`, one knot vector or two.

use std::{borrow::Cow, fmt};

use serde::{
    Deserialize, Deserializer, Serialize,
    de::{self, SeqAccess, Visitor},
};
use utoipa::{
    PartialSchema, ToSchema,
    openapi::{
        RefOr,
        schema::{ArrayBuilder, ObjectBuilder, OneOfBuilder, Schema, Type},
    },
};

/// One degree for every axis, or one for each: `3` or `[p, q]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum DegreeBody {
    Both(usize),
    Each([usize; 2]),
}

/// Equal spans over the domain, the same number on every axis or one for each: `8` or `[a, b]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum SpansBody {
    Both(usize),
    Each([usize; 2]),
}

/// How many of the smallest eigenvalues are regularised: a number or `auto`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum CountBody {
    Auto(AutoName),
    Given(usize),
}

/// `auto`
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AutoName {
    Auto,
}

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

fn whole(minimum: u32) -> ObjectBuilder {
    ObjectBuilder::new().schema_type(Type::Integer).minimum(Some(minimum))
}

fn list(items: impl Into<RefOr<Schema>>, lengths: Option<(usize, usize)>) -> ArrayBuilder {
    ArrayBuilder::new().items(items.into()).min_items(lengths.map(|l| l.0)).max_items(lengths.map(|l| l.1))
}

/// Documents a union of plain values under its name.
macro_rules! documented {
    ($body:ident, $name:literal, $description:literal, $first:expr, $second:expr $(,)?) => {
        impl PartialSchema for $body {
            fn schema() -> RefOr<Schema> {
                OneOfBuilder::new().description(Some($description)).item($first).item($second).into()
            }
        }

        impl ToSchema for $body {
            fn name() -> Cow<'static, str> {
                $name.into()
            }
        }
    };
}

documented!(
    DegreeBody,
    "Degree",
    "One degree for every axis, or one for each: `3` or `[p, q]`.",
    whole(0),
    list(whole(0), Some((2, 2))),
);
documented!(
    SpansBody,
    "Spans",
    "Equal spans over the domain, the same number on every axis or one for each: `8` or `[a, b]`.",
    whole(1),
    list(whole(1), Some((2, 2))),
);
documented!(
    CountBody,
    "Count",
    "How many of the smallest eigenvalues are regularised: a number or `auto`.",
    ObjectBuilder::new().schema_type(Type::String).enum_values(Some(["auto"])),
    whole(0),
);
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

/// A whole number or two of them.
enum OneOrTwo {
    One(usize),
    Two([usize; 2]),
}

impl<'de> Deserialize<'de> for OneOrTwo {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;

        impl<'de> Visitor<'de> for Read {
            type Value = OneOrTwo;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a whole number of at least 0 or an array of two of them")
            }

            fn visit_u64<E: de::Error>(self, value: u64) -> Result<OneOrTwo, E> {
                usize::try_from(value)
                    .map(OneOrTwo::One)
                    .map_err(|_| E::invalid_value(de::Unexpected::Unsigned(value), &self))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<OneOrTwo, A::Error> {
                let first = entries.next_element()?.ok_or_else(|| de::Error::invalid_length(0, &self))?;
                let second = entries.next_element()?.ok_or_else(|| de::Error::invalid_length(1, &self))?;
                if entries.next_element::<de::IgnoredAny>()?.is_some() {
                    return Err(de::Error::invalid_length(3, &self));
                }
                Ok(OneOrTwo::Two([first, second]))
            }
        }

        deserializer.deserialize_any(Read)
    }
}

impl<'de> Deserialize<'de> for DegreeBody {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        OneOrTwo::deserialize(deserializer).map(|value| match value {
            OneOrTwo::One(n) => DegreeBody::Both(n),
            OneOrTwo::Two(pair) => DegreeBody::Each(pair),
        })
    }
}

impl<'de> Deserialize<'de> for SpansBody {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        OneOrTwo::deserialize(deserializer).map(|value| match value {
            OneOrTwo::One(n) => SpansBody::Both(n),
            OneOrTwo::Two(pair) => SpansBody::Each(pair),
        })
    }
}

impl<'de> Deserialize<'de> for CountBody {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;

        impl Visitor<'_> for Read {
            type Value = CountBody;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("\"auto\" or a whole number of at least 0")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<CountBody, E> {
                match text {
                    "auto" => Ok(CountBody::Auto(AutoName::Auto)),
                    other => Err(E::invalid_value(de::Unexpected::Str(other), &self)),
                }
            }

            fn visit_u64<E: de::Error>(self, value: u64) -> Result<CountBody, E> {
                usize::try_from(value)
                    .map(CountBody::Given)
                    .map_err(|_| E::invalid_value(de::Unexpected::Unsigned(value), &self))
            }
        }

        deserializer.deserialize_any(Read)
    }
}

/// An entry of `knots`, by which the two forms are told apart.
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

impl<'de> Deserialize<'de> for WeightsBody {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;

        impl<'de> Visitor<'de> for Read {
            type Value = WeightsBody;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an array of numbers (curve) or rows of numbers (surface)")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<WeightsBody, A::Error> {
                match entries.next_element()? {
                    None => Ok(WeightsBody::Curve(Vec::new())),
                    Some(KnotEntry::Number(first)) => {
                        let mut weights = vec![first];
                        while let Some(weight) = entries.next_element()? {
                            weights.push(weight);
                        }
                        Ok(WeightsBody::Curve(weights))
                    }
                    Some(KnotEntry::List(first)) => {
                        let mut rows = vec![first];
                        while let Some(row) = entries.next_element()? {
                            rows.push(row);
                        }
                        Ok(WeightsBody::Surface(rows))
                    }
                }
            }
        }

        deserializer.deserialize_seq(Read)
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
