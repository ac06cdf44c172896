//! The query parameter `include`: names of additional parts of the response, separated by commas.

use axum::http::HeaderMap;
use serde::{
    Deserialize,
    de::{DeserializeOwned, value::StrDeserializer},
};

use super::accept::Format;
use crate::{
    api::{
        faults::Faults,
        gears::correction::{
            csv::OutsideLimitsName,
            include::{CorrectionInclude, StoredIncludeName},
        },
        json::{refusal::Refusal, text::ShortText},
        problem::Problem,
    },
    usecases::correct::Form,
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IncludeQuery {
    include: Option<String>,
}

impl IncludeQuery {
    /// Returns the names; a repeated one counts once, an unknown one is refused.
    pub fn names<T: DeserializeOwned>(&self) -> Result<Vec<T>, Problem> {
        names(self.include.as_deref())
    }
}

/// The query of a table that is read.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableQuery {
    include: Option<String>,
    instrument: Option<String>,
}

impl TableQuery {
    /// The names of `include`, likewise.
    pub fn names<T: DeserializeOwned>(&self) -> Result<Vec<T>, Problem> {
        names(self.include.as_deref())
    }

    pub fn instrument(&self) -> Result<Option<ShortText>, Problem> {
        value(self.instrument.as_deref(), "/instrument")
    }
}

/// The query of a stored correction.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CorrectionQuery {
    include: Option<String>,
    /// Whether the CSV is returned although predicted figures lie outside their limits.
    outside_limits: Option<String>,
}

impl CorrectionQuery {
    /// Returns the format that the client accepts, with what it contains.
    pub fn form(&self, headers: &HeaderMap) -> Result<(Format, Form), Problem> {
        let format = Format::negotiated(headers, Format::Csv, "Corrections")?;
        let names: Vec<StoredIncludeName> = names(self.include.as_deref())?;
        let permission: Option<OutsideLimitsName> = value(self.outside_limits.as_deref(), "/outside_limits")?;
        let form = match format {
            Format::Csv => Form::Csv { outside_limits: permission == Some(OutsideLimitsName::Allowed) },
            _ => Form::Json(CorrectionInclude::of_stored(&names)),
        };
        Ok((format, form))
    }
}

/// Returns the value of a query parameter, which the pointer names.
fn value<T: DeserializeOwned>(text: Option<&str>, pointer: &str) -> Result<Option<T>, Problem> {
    let fault = |refusal: Refusal| Problem::invalid(Faults::one(pointer, refusal.to_string()));
    text.map(|text| T::deserialize(StrDeserializer::new(text))).transpose().map_err(fault)
}

fn names<T: DeserializeOwned>(include: Option<&str>) -> Result<Vec<T>, Problem> {
    let mut faults = Faults::default();
    let mut names = Vec::new();
    for name in include.iter().flat_map(|names| names.split(',')) {
        match T::deserialize(StrDeserializer::<Refusal>::new(name)) {
            Ok(name) => names.push(name),
            Err(refusal) => faults.push("/include", refusal.to_string()),
        }
    }
    faults.into_result(names).map_err(Problem::invalid)
}
