//! Number of eigenvalues to regularise: `"auto"` or a number.

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize,
    de::{self, Visitor},
};
use utoipa::openapi::schema::{ObjectBuilder, Type};

use crate::api::json::union_schema::{documented, whole};

/// Number of smallest eigenvalues to regularise: a number or `auto`.
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

documented!(
    CountBody,
    "Count",
    "Number of smallest eigenvalues to regularise: a number or `auto`.",
    ObjectBuilder::new().schema_type(Type::String).enum_values(Some(["auto"])),
    whole(0),
);

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
