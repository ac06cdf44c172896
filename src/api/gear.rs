//! A gear's data. A job keeps them as they were given: shape and signs are checked, nothing is computed from them yet.

use serde::{Deserialize, Deserializer, Serialize, de::Error};
use utoipa::ToSchema;

use super::fit_spec::present;
use crate::estimation::words::{Shown, counted};

/// An involute gear, in the usual terms of DIN 3960 / ISO 21771.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Gear, example = json!({
    "teeth": 83, "normal_module_mm": 2.03, "normal_pressure_angle_deg": 18.0, "helix_angle_deg": 28.0, "hand": "right",
    "profile_shift_coefficient": 0.0, "face_width_mm": 30.0
}))]
pub struct GearBody {
    #[serde(deserialize_with = "teeth")]
    #[schema(minimum = 1, maximum = 10000)]
    pub teeth: u32,
    #[serde(deserialize_with = "positive")]
    #[schema(exclusive_minimum = 0)]
    pub normal_module_mm: f64,
    #[serde(default, deserialize_with = "angle", skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = -90, exclusive_maximum = 90)]
    pub normal_pressure_angle_deg: Option<f64>,
    #[serde(default, deserialize_with = "angle", skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = -90, exclusive_maximum = 90)]
    pub helix_angle_deg: Option<f64>,
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub hand: Option<HandName>,
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub profile_shift_coefficient: Option<f64>,
    #[serde(default, deserialize_with = "maybe_positive", skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0)]
    pub face_width_mm: Option<f64>,
    #[serde(default, deserialize_with = "maybe_positive", skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0)]
    pub tip_diameter_mm: Option<f64>,
    #[serde(default, deserialize_with = "maybe_positive", skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0)]
    pub root_diameter_mm: Option<f64>,
    /// Whether the teeth point inwards. Default false.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub internal: Option<bool>,
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub tool: Option<GearToolBody>,
}

/// Direction of the helix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum HandName {
    Right,
    Left,
}

/// The tool that generates the root.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = GearTool)]
pub struct GearToolBody {
    #[serde(default, deserialize_with = "not_negative", skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0)]
    pub tip_radius_mm: Option<f64>,
    #[serde(default, deserialize_with = "not_negative", skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0)]
    pub addendum_factor: Option<f64>,
    #[serde(default, deserialize_with = "not_negative", skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0)]
    pub protuberance_mm: Option<f64>,
}

const MOST_TEETH: u32 = 10_000;

fn teeth<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u32, D::Error> {
    let teeth = u32::deserialize(deserializer)?;
    if (1..=MOST_TEETH).contains(&teeth) {
        Ok(teeth)
    } else {
        Err(D::Error::custom(format_args!(
            "{}; a gear has 1 to {MOST_TEETH}",
            counted(teeth as usize, "tooth", "teeth")
        )))
    }
}

fn positive<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    checked(deserializer, |value| value > 0.0, "must be greater than 0")
}

fn maybe_positive<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    positive(deserializer).map(Some)
}

fn not_negative<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    checked(deserializer, |value| value >= 0.0, "must not be negative").map(Some)
}

fn angle<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    checked(deserializer, |value| value.abs() < 90.0, "must lie between -90 and 90 degrees").map(Some)
}

fn checked<'de, D: Deserializer<'de>>(
    deserializer: D,
    holds: impl Fn(f64) -> bool,
    otherwise: &str,
) -> Result<f64, D::Error> {
    let value = f64::deserialize(deserializer)?;
    if holds(value) { Ok(value) } else { Err(D::Error::custom(format_args!("{} {otherwise}", Shown(value)))) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<GearBody, String> {
        serde_json::from_str(text).map_err(|error| error.to_string())
    }

    #[test]
    fn a_gear_comes_back_as_it_was_given() {
        let text = r#"{"teeth":83,"normal_module_mm":2.03,"normal_pressure_angle_deg":18.0,"helix_angle_deg":28.0,"hand":"left","profile_shift_coefficient":0.0,"face_width_mm":30.0,"internal":false,"tool":{"tip_radius_mm":0.2}}"#;
        assert_eq!(serde_json::to_string(&read(text).unwrap()).unwrap(), text);
    }

    #[test]
    fn wrong_shapes_are_refused() {
        for (text, why) in [
            (r#"{"teeth":0,"normal_module_mm":1}"#, "0 teeth"),
            (r#"{"teeth":20,"normal_module_mm":-1}"#, "greater than 0"),
            (r#"{"teeth":20}"#, "normal_module_mm"),
            (r#"{"teeth":20,"normal_module_mm":1,"helix_angle_deg":90}"#, "between"),
            (r#"{"teeth":20,"normal_module_mm":1,"colour":"blue"}"#, "unknown field `colour`"),
            (r#"{"teeth":20.5,"normal_module_mm":1}"#, "invalid type"),
        ] {
            assert!(read(text).unwrap_err().contains(why), "{text}");
        }
    }
}
