//! One whole number for every axis, or one for each: `3` or `[p, q]`.

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize,
    de::{self, SeqAccess, Visitor},
};

use crate::api::json::union_schema::{documented, list, whole};

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
