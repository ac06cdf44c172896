//! Run-out in answers about pitches.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{conformity::ConformityBody, pitch_limits::HeldBody};
use crate::api::gears::notice::NoticeBody;
use flankfit_engine::gear::{evaluation::runout::Runout, tolerance::Class};

/// Run-out.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = GearRunout)]
pub struct RunoutBody {
    /// F_r: the range of the readings all around.
    pub runout_um: f64,
    /// Whether it follows from pitches, without a probe.
    pub derived: bool,
    /// Radial readings in each tooth space, posted or derived; `null` where undefined.
    pub readings_um: Vec<Option<f64>>,
    pub eccentricity: Option<EccentricityBody>,
    /// Tooth spaces without a reading.
    pub missing: usize,
    /// 1 to 11; left out where there is none.
    pub class: Option<u8>,
    /// Whether it exceeds even class 11.
    pub beyond_classes: bool,
    /// What F_r was held against.
    #[schema(min_items = 2, max_items = 2)]
    pub limits_um: Option<[f64; 2]>,
    /// Whether F_r lies within, as it was measured. There where there are limits; where readings
    /// are missing it is false or left out.
    pub within: Option<bool>,
    /// There where there are limits and an uncertainty, and no reading is missing.
    pub conformity: Option<ConformityBody>,
    /// What to know about the run-out; empty where there is nothing to say.
    pub warnings: Vec<NoticeBody>,
}

/// The first harmonic of the readings.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Eccentricity)]
pub struct EccentricityBody {
    /// Distance of the gear's axis from the axis of rotation: half the range of the harmonic.
    pub amount_um: f64,
    /// Of the amount, from what the harmonic leaves; left out where too few readings are defined.
    pub std_error_um: Option<f64>,
    /// Where the readings are greatest, in the direction of counting from the first one.
    pub angle_deg: f64,
}

impl RunoutBody {
    /// Combines the result with the limits it was compared with.
    pub fn new(held: HeldBody, runout: Runout) -> Self {
        let (class, beyond_classes) = match runout.class {
            Some(Class::Within(class)) => (Some(class), false),
            Some(Class::Beyond) => (None, true),
            None => (None, false),
        };
        RunoutBody {
            runout_um: runout.runout,
            derived: runout.derived,
            readings_um: runout.readings,
            eccentricity: runout.eccentricity.map(|found| EccentricityBody {
                amount_um: found.amount,
                std_error_um: found.std_error,
                angle_deg: found.angle.to_degrees(),
            }),
            missing: runout.missing,
            class,
            beyond_classes,
            limits_um: held.limits,
            within: held.within,
            conformity: held.conformity,
            warnings: runout.warnings.iter().map(NoticeBody::from).collect(),
        }
    }
}
