//! Limits of pitch deviations and run-out on the wire.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::conformity::{ConformityBody, check_ascending, check_class};
use crate::api::faults::Faults;
use flankfit_engine::gear::{
    Side,
    evaluation::pitch_limits::{Held, PitchLimits},
};

/// What pitch deviations and the run-out must lie within, `[low, high]` in µm. Each figure that has
/// limits is answered with whether it lies within, and with its conformity where
/// `standard_uncertainty_um` tells how sure it is.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = PitchLimits, example = json!({"class": 6, "runout_um": [0, 15], "left": {"single_pitch_um": [-5, 5]}}))]
pub struct PitchLimitsBody {
    /// Class 1 to 11 of ISO 1328-1:2013: its tolerances bound what no limits are given for here.
    #[schema(minimum = 1, maximum = 11)]
    pub class: Option<u8>,
    /// Of every single pitch deviation f_pi of both flanks.
    #[schema(min_items = 2, max_items = 2)]
    pub single_pitch_um: Option<[f64; 2]>,
    /// Of F_p of both flanks.
    #[schema(min_items = 2, max_items = 2)]
    pub cumulative_pitch_um: Option<[f64; 2]>,
    /// Of F_r.
    #[schema(min_items = 2, max_items = 2)]
    pub runout_um: Option<[f64; 2]>,
    /// Of left flanks: each limit here goes before the one for both.
    pub left: Option<FlankPitchLimitsBody>,
    /// Of right flanks, likewise.
    pub right: Option<FlankPitchLimitsBody>,
}

/// What pitch deviations of one flank must lie within, `[low, high]` in µm.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = FlankPitchLimits)]
pub struct FlankPitchLimitsBody {
    /// Of every single pitch deviation f_pi.
    #[schema(min_items = 2, max_items = 2)]
    pub single_pitch_um: Option<[f64; 2]>,
    /// Of F_p.
    #[schema(min_items = 2, max_items = 2)]
    pub cumulative_pitch_um: Option<[f64; 2]>,
}

/// Standard uncertainty of the measurement (one standard deviation, not an expanded one), which the
/// pitches themselves do not tell. What has none is answered without a decision.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = PitchUncertainty)]
pub struct PitchUncertaintyBody {
    /// Of a single pitch deviation.
    #[schema(exclusive_minimum = 0, maximum = 1e6)]
    pub single_pitch: Option<f64>,
    /// Of F_p.
    #[schema(exclusive_minimum = 0, maximum = 1e6)]
    pub cumulative_pitch: Option<f64>,
    /// Of F_r.
    #[schema(exclusive_minimum = 0, maximum = 1e6)]
    pub runout: Option<f64>,
}

/// No probe is less sure, µm.
const MOST_UNCERTAINTY: f64 = 1e6;

impl PitchLimitsBody {
    /// Those of a flank and of the run-out.
    pub fn of(&self, side: Side) -> PitchLimits {
        let own = match side {
            Side::Left => self.left,
            Side::Right => self.right,
        }
        .unwrap_or_default();
        PitchLimits {
            class: self.class,
            single_pitch: own.single_pitch_um.or(self.single_pitch_um),
            cumulative: own.cumulative_pitch_um.or(self.cumulative_pitch_um),
            runout: self.runout_um,
        }
    }

    /// Refuses what no gear could mend.
    pub fn check(&self, at: &str, faults: &mut Faults) {
        check_class(self.class, at, faults);
        let both = [
            ("single_pitch_um", self.single_pitch_um),
            ("cumulative_pitch_um", self.cumulative_pitch_um),
            ("runout_um", self.runout_um),
        ];
        check_ascending(&both, at, faults);
        for (name, own) in [("left", self.left), ("right", self.right)] {
            let Some(own) = own else { continue };
            let told = [("single_pitch_um", own.single_pitch_um), ("cumulative_pitch_um", own.cumulative_pitch_um)];
            check_ascending(&told, &format!("{at}/{name}"), faults);
        }
    }
}

impl PitchUncertaintyBody {
    pub fn check(&self, at: &str, faults: &mut Faults) {
        let told =
            [("single_pitch", self.single_pitch), ("cumulative_pitch", self.cumulative_pitch), ("runout", self.runout)];
        for (name, value) in told {
            if let Some(value) = value.filter(|value| !(*value > 0.0 && *value <= MOST_UNCERTAINTY)) {
                faults.push(format!("{at}/{name}"), format!("{value} is not above 0 and at most {MOST_UNCERTAINTY}"));
            }
        }
    }
}

/// What became of a figure that has limits.
#[derive(Clone, Copy, Debug, Default)]
pub struct HeldBody {
    pub limits: Option<[f64; 2]>,
    pub within: Option<bool>,
    pub conformity: Option<ConformityBody>,
}

impl From<Option<Held>> for HeldBody {
    fn from(held: Option<Held>) -> Self {
        HeldBody {
            limits: held.map(|held| held.limits),
            within: held.and_then(|held| held.within),
            conformity: held.and_then(|held| held.conformity).map(Into::into),
        }
    }
}
