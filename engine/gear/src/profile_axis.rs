//! Coordinates along the profile.

use super::Gear;
use flankfit_numerics::fault::{Faults, words::Shown};

/// What profile values are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ProfileAxis {
    /// √(r² − r_b²), mm.
    #[default]
    RollLength,
    /// L / r_b, rad.
    RollAngle,
    /// mm.
    Diameter,
}

/// A place along the profile where there is no involute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoInvolute {
    /// What the value is.
    pub axis: ProfileAxis,
    /// mm, or rad.
    pub value: f64,
    /// d_b, mm.
    pub base_diameter: f64,
}

impl std::fmt::Display for NoInvolute {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let value = Shown(self.value);
        match self.axis {
            ProfileAxis::RollLength => write!(f, "a roll length of {value} mm has no involute"),
            ProfileAxis::RollAngle => write!(f, "a roll angle of {value} rad has no involute"),
            ProfileAxis::Diameter => write!(
                f,
                "a diameter of {value} mm, where the base circle has {} mm, has no involute",
                Shown(self.base_diameter)
            ),
        }
    }
}

impl std::error::Error for NoInvolute {}

/// What no gear reaches, and no square of it overflows, mm.
const MOST_ROLL_LENGTH: f64 = 1e7;

impl ProfileAxis {
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

    /// Roll lengths of `values`; faults by their indices.
    pub fn roll_lengths(self, gear: &Gear, values: &[f64]) -> Result<Vec<f64>, Faults<usize, NoInvolute>> {
        let mut faults = Faults::default();
        let mut rolls = Vec::with_capacity(values.len());
        for (index, &value) in values.iter().enumerate() {
            match self.roll_length(gear, value) {
                Some(roll) => rolls.push(roll),
                None => {
                    let base_diameter = 2.0 * gear.base_radius();
                    faults.push(index, NoInvolute { axis: self, value, base_diameter });
                }
            }
        }
        faults.into_result(rolls)
    }
}
