//! Of gears, registrations and corrections.

use super::Params;
use flankfit_engine::gear::{
    geometry::Warning as Unusual,
    tolerance::{OutOfScope, Quantity},
    warning::Warning,
};

impl From<&Warning> for Params {
    fn from(warning: &Warning) -> Self {
        let none = Params::new();
        match warning {
            Warning::RegistrationNotConverged(iterations) => none.with("iterations", *iterations),
            Warning::MotionsIndistinguishable(motions) => {
                none.list("motions", motions.iter().map(|motion| motion.name()))
            }
            Warning::AxialShiftByModification(shift) => none.with("shift_um", *shift),
            Warning::AxialShiftForRotation { shift, rotation } => {
                none.with("shift_um", *shift).with("rotation_urad", *rotation)
            }
            Warning::NodesLost { count, first, .. } => none.with("count", *count).with("first", *first),
            Warning::RotationModuloPitch(pitch) => none.with("pitch_urad", *pitch),
            Warning::TeethContradict(count) | Warning::FlanksReassigned(count) | Warning::PointsBeyondFlank(count) => {
                none.with("count", *count)
            }
            Warning::PoorFit { rms, limit } => none.with("rms_um", *rms).with("limit_um", *limit),
            Warning::PointsMisfit { count, first, deviation } => {
                none.with("count", *count).with("first", *first).with("deviation_um", *deviation)
            }
            Warning::SettingsLimited(settings)
            | Warning::UndeterminedSettingsMoved(settings)
            | Warning::LimitsWithoutEffect(settings)
            | Warning::UndeterminedSettings { settings, .. } => none.list("settings", settings.clone()),
            // they hold nothing, or a sentence
            _ => none,
        }
    }
}

impl From<&OutOfScope> for Params {
    fn from(OutOfScope(excesses): &OutOfScope) -> Self {
        let each = excesses.iter().map(|excess| {
            serde_json::json!({"quantity": quantity(excess.quantity), "value": excess.value, "scope": excess.scope})
        });
        Params::new().list("outside", each)
    }
}

/// By the field of a gear.
pub fn quantity(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Teeth => "teeth",
        Quantity::ReferenceDiameter => "reference_diameter_mm",
        Quantity::NormalModule => "normal_module_mm",
        Quantity::HelixAngle => "helix_angle_deg",
        Quantity::FaceWidth => "face_width_mm",
    }
}

impl From<&Unusual> for Params {
    fn from(warning: &Unusual) -> Self {
        let none = Params::new();
        match *warning {
            Unusual::Undercut { profile_shift, least, form_diameter } => none
                .with("profile_shift_coefficient", profile_shift)
                .with("least_profile_shift_coefficient", least)
                .with("form_diameter_mm", form_diameter),
            Unusual::Protuberance { protuberance, form_diameter } => {
                none.with("protuberance_mm", protuberance).with("form_diameter_mm", form_diameter)
            }
            Unusual::PointedTip { pointed_diameter, tip_diameter } => {
                none.with("pointed_diameter_mm", pointed_diameter).with("tip_diameter_mm", tip_diameter)
            }
            Unusual::ThinTip { thickness, least } => none.with("thickness_mm", thickness).with("least_mm", least),
            Unusual::TipBelowForm { tip_diameter, form_diameter } => {
                none.with("tip_diameter_mm", tip_diameter).with("form_diameter_mm", form_diameter)
            }
            Unusual::TipBelowBase { tip_diameter, base_diameter } => {
                none.with("tip_diameter_mm", tip_diameter).with("base_diameter_mm", base_diameter)
            }
            Unusual::RootBelowTool { root_diameter, generated }
            | Unusual::RootAboveTool { root_diameter, generated } => {
                none.with("root_diameter_mm", root_diameter).with("generated_diameter_mm", generated)
            }
            Unusual::FewTeeth { teeth } => none.with("teeth", teeth),
            Unusual::ToolAssumed { addendum, tip_radius } => {
                none.with("addendum_mm", addendum).with("tip_radius_mm", tip_radius)
            }
            Unusual::NoFillet { root_diameter } => none.with("root_diameter_mm", root_diameter),
            Unusual::InternalRoot { radius, protuberance } => {
                none.with("radius_mm", radius).with("protuberance_mm", protuberance)
            }
            Unusual::RootRadius { asked, used } => none.with("asked_mm", asked).with("used_mm", used),
        }
    }
}
