//! A gear's data: kept by a job as they were given, checked as a whole before anything is computed
//! from them.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::{
    api::{faults::Faults, problem::Problem, warning::WarningBody},
    jobs::Job,
};
use flankfit_engine::gear::{Gear, GearData, Hand, Tool, data::DEDENDUM};

/// An involute gear, in the usual terms of DIN 3960 / ISO 21771.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Gear, example = json!({
    "teeth": 83, "normal_module_mm": 2.03, "normal_pressure_angle_deg": 18.0, "helix_angle_deg": 28.0, "hand": "right",
    "profile_shift_coefficient": 0.0, "face_width_mm": 30.0
}))]
pub struct GearBody {
    /// z, the number of teeth; an internal gear is marked by `internal`.
    #[schema(minimum = 1, maximum = 10000)]
    pub teeth: u32,
    /// m_n, mm.
    #[schema(minimum = 0.001, maximum = 1e6)]
    pub normal_module_mm: f64,
    /// α_n. Default 20.
    #[schema(minimum = 0.1, exclusive_maximum = 80)]
    pub normal_pressure_angle_deg: Option<f64>,
    /// β on the reference cylinder. Default 0; below 0 is a left-hand helix.
    #[schema(exclusive_minimum = -89, exclusive_maximum = 89)]
    pub helix_angle_deg: Option<f64>,
    /// Default right, where the helix angle is not below 0.
    pub hand: Option<Hand>,
    /// x, positive towards the tip of the tooth, also for internal gears. Default 0.
    #[schema(minimum = -100, maximum = 100)]
    pub profile_shift_coefficient: Option<f64>,
    /// b, mm. Without it there are no helix tolerances and no evaluation range by default.
    #[schema(minimum = 0.001, maximum = 1e6)]
    pub face_width_mm: Option<f64>,
    /// d_a. By default an addendum of (1 + x) m_n.
    #[schema(minimum = 0.001, maximum = 1e6)]
    pub tip_diameter_mm: Option<f64>,
    /// d_f. By default a dedendum of (addendum factor of the tool − x) m_n.
    #[schema(minimum = 0.001, maximum = 1e6)]
    pub root_diameter_mm: Option<f64>,
    /// True if the teeth point inwards. Default false.
    pub internal: Option<bool>,
    pub tool: Option<GearToolBody>,
}

/// The gear of a job, which was checked when the job was given it.
pub fn of_job(job: &Job) -> Result<Option<Gear>, Problem> {
    job.gear.as_deref().map(of_text).transpose()
}

/// A gear as it was stored.
pub fn of_text(text: &str) -> Result<Gear, Problem> {
    let body: GearBody = serde_json::from_str(text).map_err(Problem::internal)?;
    body.checked("/gear").map_err(Problem::invalid)
}

impl GearBody {
    /// A warning where the hand of a helix had to be assumed.
    pub fn hand_assumed(&self) -> Option<WarningBody> {
        let assumed = self.hand.is_none() && self.helix_angle_deg.is_some_and(|angle| angle > 0.0);
        assumed.then(|| WarningBody::new("hand_assumed", "no `hand` is given: a right-hand helix is assumed"))
    }

    /// Returns the gear; pointers of errors begin with `at`.
    pub fn checked(&self, at: &str) -> Result<Gear, Faults> {
        let helix = self.helix_angle_deg.unwrap_or(0.0);
        let left = helix < 0.0;
        if left && self.hand == Some(Hand::Right) {
            let detail = "a helix angle below 0 is a left-hand helix, `hand` says right";
            return Err(Faults::one(format!("{at}/hand"), detail));
        }
        let data = GearData {
            teeth: self.teeth,
            normal_module: self.normal_module_mm,
            pressure_angle: self.normal_pressure_angle_deg.unwrap_or(PRESSURE_ANGLE).to_radians(),
            helix_angle: helix.abs().to_radians(),
            hand: if left || self.hand == Some(Hand::Left) { Hand::Left } else { Hand::Right },
            profile_shift: self.profile_shift_coefficient.unwrap_or(0.0),
            face_width: self.face_width_mm,
            tip_diameter: self.tip_diameter_mm,
            root_diameter: self.root_diameter_mm,
            internal: self.internal.unwrap_or(false),
            tool: self.tool.as_ref().map(|tool| Tool {
                tip_radius: tool.tip_radius_mm.unwrap_or(TIP_RADIUS * self.normal_module_mm),
                addendum_factor: tool.addendum_factor.unwrap_or(DEDENDUM),
                protuberance: tool.protuberance_mm.unwrap_or(0.0),
            }),
        };
        Gear::new(data).map_err(|faults| Faults::of_engine(at, &faults))
    }
}

/// α_n without data, degrees.
const PRESSURE_ANGLE: f64 = 20.0;
/// Tip radius of the tool without data, in normal modules (ISO 53, profile A).
const TIP_RADIUS: f64 = 0.38;

/// The tool that generates the root.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = GearTool)]
pub struct GearToolBody {
    /// Default 0.38 m_n (ISO 53, profile A).
    #[schema(minimum = 0, maximum = 1e6)]
    pub tip_radius_mm: Option<f64>,
    /// In normal modules. Default 1.25.
    #[schema(minimum = 0, maximum = 1e6)]
    pub addendum_factor: Option<f64>,
    /// Protuberance of the tool, in the normal section. Default 0.
    #[schema(minimum = 0, maximum = 1e6)]
    pub protuberance_mm: Option<f64>,
}
