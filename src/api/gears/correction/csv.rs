//! A kept correction as CSV for the control of a machine, under the names of OPC UA for Geometrical
//! Measuring Systems.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    figures::{SidedBody, symbol, tenth},
    request::{CorrectionRequestBody, LimitsBody},
    result::CorrectionResultBody,
};
use crate::{
    api::{
        json::text::Moment,
        problem::{Problem, ProblemCode},
    },
    jobs::{Job, Record},
};
use flankfit_engine::{
    formats::gms::{self, Unit},
    gear::correction::{Change, Unchanged},
};

/// Permission to export a correction whose predicted figures are outside their limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = OutsideLimits)]
pub enum OutsideLimitsName {
    Allowed,
}

/// Job and measurements of the correction.
pub struct About<'a> {
    pub job: &'a Job,
    /// In words.
    pub flanks: String,
    /// The iterations whose nodes were corrected.
    pub iterations: &'a [u32],
}

/// A line for each setting: its change as the relative value, limits of the change as control
/// limits, and what it is for. Refuses a correction whose predicted figures lie outside their
/// limits, unless that is `allowed`.
pub fn write(record: &Record, about: &About<'_>, allowed: bool) -> Result<Vec<u8>, Problem> {
    let request: CorrectionRequestBody = serde_json::from_str(&record.draft.request).map_err(Problem::internal)?;
    let result = CorrectionResultBody::of(record)?;
    let figures = result.figures.unwrap_or_default();
    let outside = figures.outside();
    if !outside.is_empty() && !allowed {
        let each = outside.iter().map(|(name, figure)| {
            let [low, high] = figure.limits.unwrap_or_default();
            format!("{} {} µm of {low} to {high} µm", symbol(name), tenth(figure.predicted))
        });
        let detail = format!(
            "{} would be outside the limits; send `?outside_limits=allowed` to export the correction anyway.",
            each.collect::<Vec<_>>().join(", ")
        );
        return Err(Problem::new(ProblemCode::PredictedOutsideLimits, detail));
    }
    let limits = request.limits.unwrap_or_default();
    let each = result.settings.into_iter().map(|change| {
        let LimitsBody { min, max, increment, .. } = limits.get(&change.name).copied().unwrap_or_default();
        let rounded = rounded(&change, increment);
        gms::Correction {
            description: Some(description(&change, rounded)),
            characteristic: change.name.clone(),
            identifier: change.name,
            relative: Some(rounded),
            absolute: None,
            upper_limit: max,
            lower_limit: min,
            unit: Unit::named(&change.unit),
            program: None,
        }
    });
    let Job { id, part_number, serial_number, .. } = about.job;
    let numbers: Vec<String> = about.iterations.iter().map(u32::to_string).collect();
    // if the iteration has no flank, the one that the correction was made for
    let side = match figures {
        SidedBody { left: Some(_), right: None } => "the left flank",
        SidedBody { left: None, right: Some(_) } => "the right flank",
        SidedBody { .. } => "a flank",
    };
    let columns = [
        ("Flank", about.flanks.replacen("a flank", side, 1)),
        ("Job", id.to_string()),
        ("Iterations", numbers.join(" ")),
        ("PartNumber", part_number.clone().unwrap_or_default()),
        ("SerialNumber", serial_number.clone().unwrap_or_default()),
        ("Date", Moment(record.created_at).to_string()),
    ];
    let text = gms::write_csv(&each.collect::<Vec<_>>(), &columns).map_err(Problem::internal)?;
    Ok(text.into_bytes())
}

/// Returns the change as the control takes it: a multiple of the increment, else two digits of its
/// standard error, else four digits.
fn rounded(change: &Change, increment: Option<f64>) -> f64 {
    let digits = |size: f64, digits: i32| digits - 1 - size.abs().log10().floor() as i32;
    let to = |places: i32| {
        let places = places.clamp(0, 12) as u32;
        let scale = f64::from(10u32).powi(places as i32);
        (change.change * scale).round() / scale + 0.0
    };
    match (increment, change.std_error) {
        (Some(_), _) => change.change,
        _ if change.change == 0.0 => 0.0,
        (None, Some(error)) if error > 0.0 => to(digits(error, 2)),
        (None, _) => to(digits(change.change, 4)),
    }
}

/// Returns the change in words: sign and size, what the machine is moved towards, how sure it is.
fn description(change: &Change, rounded: f64) -> String {
    let name = change.name.replace('_', " ");
    if rounded == 0.0 {
        let why = match () {
            () if change.fixed => "fixed",
            () if change.undetermined => "not determined by this measurement",
            () if change.unchanged == Some(Unchanged::NotDistinguishable) => {
                "its change is not distinguishable from none"
            }
            () if change.unchanged == Some(Unchanged::WithinLimits) => "its figures are well within their limits",
            () => "no change",
        };
        return format!("{name}: leave ({why})");
    }
    let unit = Unit::named(&change.unit);
    let unit = match unit.display_name() {
        "1" => String::new(),
        name @ ("′" | "″" | "°" | "%") => name.to_owned(),
        name => format!(" {name}"),
    };
    let sense = sense(&change.name, rounded > 0.0).map_or_else(String::new, |sense| format!(": {sense}"));
    let note = match change.std_error {
        _ if change.limited => "; at its limit".to_owned(),
        Some(error) => format!("; standard error {error:.1e}"),
        None => String::new(),
    };
    format!("{name} {rounded:+}{unit}{sense}{note}")
}

/// Returns the meaning of a change of a machine's setting at the machine.
fn sense(setting: &str, more: bool) -> Option<&'static str> {
    // settings of one flank
    let name = setting.strip_suffix("_left").or_else(|| setting.strip_suffix("_right")).unwrap_or(setting);
    Some(match (name, more) {
        ("profile_angle", true) => "greater pressure angle of the tool, less material at the tip",
        ("profile_angle", false) => "smaller pressure angle of the tool, more material at the tip",
        ("helix_angle", true) => "towards the right hand",
        ("helix_angle", false) => "towards the left hand",
        ("profile_crowning", true) => "more removed at root and tip",
        ("profile_crowning", false) => "less removed at root and tip",
        ("helix_crowning", true) => "more removed at both ends of the face",
        ("helix_crowning", false) => "less removed at both ends of the face",
        ("twist", true) => "more material at the tip towards greater z",
        ("twist", false) => "less material at the tip towards greater z",
        ("tooth_thickness", true) => "thicker teeth",
        ("tooth_thickness", false) => "thinner teeth",
        ("infeed", true) => "wheel away from the axis of the gear",
        ("infeed", false) => "wheel towards the axis of the gear",
        ("tool_axis_offset", true) => "tool to the left (-x)",
        ("tool_axis_offset", false) => "tool to the right (+x)",
        _ => return None,
    })
}
