//! Places along a profile.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::faults::Faults;
use flankfit_engine::gear::{Gear, ProfileAxis};

/// Places along the profile.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ProfilePlaces)]
pub struct ProfileBody {
    pub axis: ProfileAxis,
    /// mm; roll angles in degrees.
    pub values: Vec<f64>,
}

impl ProfileBody {
    pub fn axis_and_values(&self) -> (ProfileAxis, Vec<f64>) {
        (self.axis, self.values.iter().map(|x| self.axis.requested(*x)).collect())
    }

    /// Returns the roll lengths; errors are at `{at}/0` ….
    pub fn roll_lengths(&self, gear: &Gear, at: &str) -> Result<Vec<f64>, Faults> {
        let (axis, values) = self.axis_and_values();
        axis.roll_lengths(gear, &values).map_err(|found| Faults::of_engine(at, &found))
    }
}
