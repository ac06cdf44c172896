//! Coordinates along the profile on the wire.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use flankfit_engine::gear::ProfileAxis;

/// A coordinate along the profile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ProfileAxis)]
pub enum ProfileAxisName {
    /// mm.
    #[default]
    RollLength,
    /// Degrees.
    RollAngle,
    /// mm.
    Diameter,
}

impl ProfileAxisName {
    /// The contract's name.
    pub fn name(self) -> &'static str {
        match self {
            ProfileAxisName::RollLength => "roll_length",
            ProfileAxisName::RollAngle => "roll_angle",
            ProfileAxisName::Diameter => "diameter",
        }
    }

    /// A value of the wire as the domain has it.
    pub fn value(self, x: f64) -> f64 {
        if self == ProfileAxisName::RollAngle { x.to_radians() } else { x }
    }
}

impl From<ProfileAxisName> for ProfileAxis {
    fn from(name: ProfileAxisName) -> Self {
        match name {
            ProfileAxisName::RollLength => ProfileAxis::RollLength,
            ProfileAxisName::RollAngle => ProfileAxis::RollAngle,
            ProfileAxisName::Diameter => ProfileAxis::Diameter,
        }
    }
}
