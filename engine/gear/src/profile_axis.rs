//! Coordinates along the profile.

use super::Gear;
use crate::check::degrees;
use flankfit_numerics::{
    check::Faults,
    words::{Shown, rounded},
};

/// Coordinate along the profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum ProfileAxis {
    /// √(r² − r_b²), mm.
    #[default]
    RollLength,
    /// L / r_b; in requests in degrees, here in rad.
    RollAngle,
    /// Diameter, mm.
    Diameter,
}

/// Roll length that no gear reaches, and whose square does not overflow, mm.
const MOST_ROLL_LENGTH: f64 = 1e7;

impl ProfileAxis {
    /// Returns the name in requests.
    pub fn name(self) -> &'static str {
        match self {
            ProfileAxis::RollLength => "roll_length",
            ProfileAxis::RollAngle => "roll_angle",
            ProfileAxis::Diameter => "diameter",
        }
    }

    /// Converts a value of a request, in which roll angles are in degrees.
    pub fn requested(self, value: f64) -> f64 {
        if self == ProfileAxis::RollAngle { value.to_radians() } else { value }
    }

    /// The roll length of a value; `None` where there is no involute.
    ///
    /// ```
    /// use flankfit_gear::{Gear, GearData, ProfileAxis};
    ///
    /// // One radian of roll is one base radius of roll length.
    /// let gear = Gear::new(GearData::spur(52, 1.0))?;
    /// assert_eq!(ProfileAxis::RollAngle.roll_length(&gear, 1.0), Some(gear.base_radius()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn roll_length(self, gear: &Gear, value: f64) -> Option<f64> {
        let roll = match self {
            ProfileAxis::RollLength => value,
            ProfileAxis::RollAngle => value * gear.base_radius(),
            ProfileAxis::Diameter => gear.roll_length(value)?,
        };
        (0.0..=MOST_ROLL_LENGTH).contains(&roll).then_some(roll)
    }

    /// The value at a roll length.
    pub fn value(self, gear: &Gear, roll: f64) -> f64 {
        match self {
            ProfileAxis::RollLength => roll,
            ProfileAxis::RollAngle => roll / gear.base_radius(),
            ProfileAxis::Diameter => gear.diameter(roll),
        }
    }

    /// Roll lengths of the list `values`.
    pub fn roll_lengths(self, gear: &Gear, values: &[f64]) -> Result<Vec<f64>, Faults> {
        let mut faults = Faults::default();
        let mut rolls = Vec::with_capacity(values.len());
        for (index, &value) in values.iter().enumerate() {
            match self.roll_length(gear, value) {
                Some(roll) => rolls.push(roll),
                None => faults.push(format_args!("[{index}]"), self.no_involute(gear, value)),
            }
        }
        faults.into_result(rolls)
    }

    /// The message of a value where there is no involute.
    fn no_involute(self, gear: &Gear, value: f64) -> String {
        match self {
            ProfileAxis::RollLength => format!("a roll length of {} mm has no involute", Shown(value)),
            ProfileAxis::RollAngle => format!("a roll angle of {}° has no involute", degrees(value)),
            ProfileAxis::Diameter => {
                let [value, base] = [value, 2.0 * gear.base_radius()].map(|x| rounded(x, 7));
                format!("a diameter of {value} mm, where the base circle has {base} mm, has no involute")
            }
        }
    }
}
