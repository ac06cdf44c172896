//! The share of gross errors that an M-estimator is the best against: a number or `"estimate"`.

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize,
    de::{self, Visitor},
};
use utoipa::openapi::schema::{ObjectBuilder, SchemaType, Type};

use crate::api::json::union_schema::documented;

/// The share of gross errors, or `estimate`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ContaminationBody {
    Estimate(EstimateName),
    Share(f64),
}

/// `estimate`
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EstimateName {
    Estimate,
}

documented!(
    ContaminationBody,
    "Contamination",
    "Share of gross errors, 1e-6 to 0.9, or `estimate`.",
    ObjectBuilder::new().schema_type(Type::String).enum_values(Some(["estimate"])),
    ObjectBuilder::new().schema_type(SchemaType::new(Type::Number)).minimum(Some(1e-6)).maximum(Some(0.9)),
);

impl<'de> Deserialize<'de> for ContaminationBody {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;

        impl Visitor<'_> for Read {
            type Value = ContaminationBody;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("\"estimate\" or a number between 0 and 1")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<ContaminationBody, E> {
                match text {
                    "estimate" => Ok(ContaminationBody::Estimate(EstimateName::Estimate)),
                    other => Err(E::invalid_value(de::Unexpected::Str(other), &self)),
                }
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> Result<ContaminationBody, E> {
                Ok(ContaminationBody::Share(value))
            }

            fn visit_u64<E: de::Error>(self, value: u64) -> Result<ContaminationBody, E> {
                Ok(ContaminationBody::Share(value as f64))
            }

            fn visit_i64<E: de::Error>(self, value: i64) -> Result<ContaminationBody, E> {
                Ok(ContaminationBody::Share(value as f64))
            }
        }

        deserializer.deserialize_any(Read)
    }
}
