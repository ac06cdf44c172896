//! A kept correction as CSV for the control of a machine, under the names of OPC UA for Geometrical
//! Measuring Systems.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize, de::IgnoredAny};
use utoipa::ToSchema;

use super::{
    figures::{SidedFiguresBody, symbol, tenth},
    request::LimitsBody,
    result::LeftName,
};
use crate::{
    api::{
        json::text::Moment,
        problem::{Problem, ProblemCode},
    },
    jobs::{Job, Record},
};
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
    #[serde(default)]
    figures: Option<SidedFiguresBody>,
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
    left: Option<LeftName>,
    #[serde(default)]
    fixed: bool,
    #[serde(default)]
    undetermined: bool,
}

/// That the predicted figures of a correction may lie outside their limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = OutsideLimits)]
pub enum OutsideLimitsName {
    Allowed,
}

/// What the correction is for.
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
    let request: Request = serde_json::from_str(&record.draft.request).map_err(Problem::internal)?;
    let result: StoredResult = serde_json::from_str(&record.draft.result).map_err(Problem::internal)?;
    let figures = result.figures.unwrap_or_default();
    let outside = figures.outside();
    if !outside.is_empty() && !allowed {
        let each = outside.iter().map(|(_, name, figure)| {
            let [low, high] = figure.limits.unwrap_or_default();
            format!("{} {} µm of {low} to {high} µm", symbol(name), tenth(figure.predicted))
        });
        let detail = format!(
            "{} would lie outside the limits; send `?outside_limits=allowed` if the machine is to be set so all the \
             same.",
            each.collect::<Vec<_>>().join(", ")
        );
        return Err(Problem::new(ProblemCode::PredictedOutsideLimits, detail));
    }
    let limits = match request.limits {
        Limits::Named(limits) => limits,
        Limits::Other(_) | Limits::None => BTreeMap::new(),
    };
    let each = result.settings.into_iter().map(|change| {
        let LimitsBody { min, max, increment, .. } = limits.get(&change.name).copied().unwrap_or_default();
        let rounded = change.rounded(increment);
        gms::Correction {
            description: Some(change.description(rounded)),
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
    // where the iteration tells no flank, the one that the correction was made for
    let side = match figures {
        SidedFiguresBody { left: Some(_), right: None } => "the left flank",
        SidedFiguresBody { left: None, right: Some(_) } => "the right flank",
        SidedFiguresBody { .. } => "a flank",
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

impl Change {
    /// The change as the control takes it: a multiple of the increment, else two digits of its
    /// standard error, else four digits.
    fn rounded(&self, increment: Option<f64>) -> f64 {
        let digits = |size: f64, digits: i32| digits - 1 - size.abs().log10().floor() as i32;
        let to = |places: i32| {
            let places = places.clamp(0, 12) as u32;
            let scale = f64::from(10u32).powi(places as i32);
            (self.change * scale).round() / scale + 0.0
        };
        match (increment, self.std_error) {
            (Some(_), _) => self.change,
            _ if self.change == 0.0 => 0.0,
            (None, Some(error)) if error > 0.0 => to(digits(error, 2)),
            (None, _) => to(digits(self.change, 4)),
        }
    }

    /// The change in words: sign and size, what the machine is moved towards, how sure it is.
    fn description(&self, rounded: f64) -> String {
        let name = self.name.replace('_', " ");
        if rounded == 0.0 {
            let why = match () {
                () if self.fixed => "fixed",
                () if self.undetermined => "not determined by this measurement",
                () if self.left == Some(LeftName::NotDistinguishable) => "its change is not distinguishable from none",
                () if self.left == Some(LeftName::WithinLimits) => "its figures are well within their limits",
                () => "no change",
            };
            return format!("{name}: leave ({why})");
        }
        let unit = Unit::named(&self.unit);
        let unit = match unit.display_name() {
            "1" => String::new(),
            name @ ("′" | "″" | "°" | "%") => name.to_owned(),
            name => format!(" {name}"),
        };
        let sense = sense(&self.name, rounded > 0.0).map_or_else(String::new, |sense| format!(": {sense}"));
        let note = match self.std_error {
            _ if self.limited => "; at its limit".to_owned(),
            Some(error) => format!("; standard error {error:.1e}"),
            None => String::new(),
        };
        format!("{name} {rounded:+}{unit}{sense}{note}")
    }
}

/// What a change of a machine's setting means at the machine.
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
