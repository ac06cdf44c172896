//! A kept correction as CSV under the names of OPC UA for Geometrical Measuring Systems.

use std::collections::BTreeMap;

use serde::{Deserialize, de::IgnoredAny};

use super::request::LimitsBody;
use crate::{api::problem::Problem, jobs::Record};
use flankfit_engine::formats::gms::{self, Unit};

/// What of the request is written.
#[derive(Deserialize)]
struct Request {
    #[serde(default)]
    limits: Limits,
}

/// By names; corrections of older versions had a list, which does not say names.
#[derive(Default, Deserialize)]
#[serde(untagged)]
enum Limits {
    Named(BTreeMap<String, LimitsBody>),
    Other(IgnoredAny),
    #[default]
    None,
}

/// What of the result is written.
#[derive(Deserialize)]
struct StoredResult {
    settings: Vec<Change>,
}

#[derive(Deserialize)]
struct Change {
    name: String,
    #[serde(default)]
    unit: String,
    change: f64,
    std_error: Option<f64>,
    limited: bool,
    #[serde(default)]
    fixed: bool,
    #[serde(default)]
    undetermined: bool,
}

/// A line for each setting: its change as the relative value, limits of the change as control
/// limits.
pub fn write(record: &Record) -> Result<Vec<u8>, Problem> {
    let request: Request = serde_json::from_str(&record.draft.request).map_err(Problem::internal)?;
    let result: StoredResult = serde_json::from_str(&record.draft.result).map_err(Problem::internal)?;
    let limits = match request.limits {
        Limits::Named(limits) => limits,
        Limits::Other(_) | Limits::None => BTreeMap::new(),
    };
    let each = result.settings.into_iter().map(|change| {
        let LimitsBody { min, max, .. } = limits.get(&change.name).copied().unwrap_or_default();
        let description = match change.std_error {
            _ if change.fixed => "fixed".to_owned(),
            _ if change.undetermined => "not determined by this measurement".to_owned(),
            _ if change.limited => "at its limit".to_owned(),
            Some(error) => format!("standard error {error:.3e}"),
            None => String::new(),
        };
        gms::Correction {
            characteristic: change.name.clone(),
            identifier: change.name,
            relative: Some(change.change),
            absolute: None,
            upper_limit: max,
            lower_limit: min,
            unit: Unit::named(&change.unit),
            description: Some(description).filter(|text| !text.is_empty()),
            program: None,
        }
    });
    let text = gms::write_csv(&each.collect::<Vec<_>>()).map_err(Problem::internal)?;
    Ok(text.into_bytes())
}
