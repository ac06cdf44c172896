//! The table of gears: which place in a request a field of the engine stands at, and what the
//! contract says of it in other words than the engine, whose angles are radians.

use flankfit_engine::{
    fault::words::{Shown, counted, entries, rounded},
    gear::{
        GearField, GearReason, Kind, NoInvolute, ProfileAxis, Refused,
        correction::fault::{CorrectionField, CorrectionReason, LimitField},
        data::{HELIX_ANGLES, PRESSURE_ANGLES},
        deviation::fault::{self as deviation, BorderField, BorderReason, MeasureField, MeasureReason},
        evaluation::fault::{
            PitchField, PitchReason, RunoutField, RunoutReason, SettingField, SurfaceField, SurfaceReason,
            ToleranceField, TraceField, TraceReason,
        },
        flank_grid::{GridField, GridReason},
        generation::fault::{ToolField, ToolReason, ToothField, ToothReason},
        modification::fault::{
            LawField, LawReason, RangeField, RangeReason, TopographyField as ReliefField,
            TopographyReason as ReliefReason,
        },
        registration::fault::{RegistrationField, RegistrationReason, pitches},
        solid::{SolidField, SolidReason},
    },
};

use crate::api::{faults::Field, json::location::escape, problem::Problem};

/// Of the object `gear`.
impl Field<GearReason> for GearField {
    fn pointer(&self) -> String {
        let name = match self {
            GearField::Teeth => "/teeth",
            GearField::NormalModule => "/normal_module_mm",
            GearField::PressureAngle => "/normal_pressure_angle_deg",
            GearField::HelixAngle => "/helix_angle_deg",
            GearField::ProfileShift => "/profile_shift_coefficient",
            GearField::FaceWidth => "/face_width_mm",
            GearField::TipDiameter => "/tip_diameter_mm",
            GearField::RootDiameter => "/root_diameter_mm",
            GearField::Tool => "/tool",
            GearField::ToolTipRadius => "/tool/tip_radius_mm",
            GearField::ToolAddendum => "/tool/addendum_factor",
            GearField::ToolProtuberance => "/tool/protuberance_mm",
        };
        name.to_owned()
    }

    fn detail(&self, reason: &GearReason) -> String {
        match reason {
            GearReason::Angle { value, .. } => {
                // of a helix the engine knows the size alone; its sign says the hand
                let helix = [-HELIX_ANGLES[1], HELIX_ANGLES[1]];
                let [low, high] = if *self == GearField::HelixAngle { helix } else { PRESSURE_ANGLES };
                format!("{}° is not within {low}° and {high}°", degrees(*value))
            }
            GearReason::NoRoot => "the root circle that follows is not above 0; give `root_diameter_mm`".to_owned(),
            GearReason::PointedTool { addendum, pressure_angle } => format!(
                "the flanks of the tool meet before its tip, an addendum of {} mm at a pressure angle of {}°",
                Shown(*addendum),
                degrees(*pressure_angle)
            ),
            other => other.to_string(),
        }
    }
}

/// An angle in few digits: on the way to radians and back the last ones of what was sent change.
fn degrees(radians: f64) -> Shown {
    let back = radians.to_degrees();
    let shown = |digits| rounded(back, digits);
    (1..=16).map(shown).find(|sent| sent.0.to_radians() == radians).unwrap_or_else(|| shown(13))
}

fn no_involute(found: &NoInvolute) -> String {
    match found.axis {
        ProfileAxis::RollAngle => format!("a roll angle of {}° has no involute", degrees(found.value)),
        ProfileAxis::RollLength | ProfileAxis::Diameter => found.to_string(),
    }
}

/// Of a list of places along the profile.
impl Field<NoInvolute> for usize {
    fn pointer(&self) -> String {
        format!("/{self}")
    }

    fn detail(&self, reason: &NoInvolute) -> String {
        no_involute(reason)
    }
}

impl Field<ToothReason> for ToothField {
    fn pointer(&self) -> String {
        match self {
            ToothField::Steps => "/steps".to_owned(),
            ToothField::Gear(field) => format!("/gear{}", field.pointer()),
        }
    }

    fn detail(&self, reason: &ToothReason) -> String {
        match (self, reason) {
            (ToothField::Gear(field), ToothReason::Gear(reason)) => field.detail(reason),
            (_, other) => other.to_string(),
        }
    }
}

/// Of a request for a solid mesh.
impl Field<SolidReason> for SolidField {
    fn pointer(&self) -> String {
        match self {
            SolidField::Gear(field) => format!("/gear{}", field.pointer()),
            SolidField::Teeth => "/teeth".to_owned(),
            SolidField::RimDiameter => "/rim_diameter_mm".to_owned(),
            SolidField::Elements => "/elements".to_owned(),
        }
    }

    fn detail(&self, reason: &SolidReason) -> String {
        match (self, reason) {
            (SolidField::Gear(field), SolidReason::Tooth(ToothReason::Gear(reason))) => field.detail(reason),
            (_, other) => other.to_string(),
        }
    }
}

/// Of the list of a tool's points.
impl Field<ToolReason> for ToolField {
    fn pointer(&self) -> String {
        match self {
            ToolField::Points => String::new(),
            ToolField::Point { index } => format!("/{index}"),
        }
    }
}

/// Of the range that modifications refer to.
impl Field<RangeReason> for RangeField {
    fn pointer(&self) -> String {
        match self {
            RangeField::Diameters => "/profile_diameter_range_mm".to_owned(),
            RangeField::Diameter { index } => format!("/profile_diameter_range_mm/{index}"),
            RangeField::Helix => "/helix_range_mm".to_owned(),
            RangeField::HelixEnd { index } => format!("/helix_range_mm/{index}"),
        }
    }
}

/// Of the list of modifications.
impl Field<LawReason> for LawField {
    fn pointer(&self) -> String {
        match self {
            LawField::List => String::new(),
            LawField::Amount { number } => format!("/{number}/amount_um"),
            LawField::StartDiameter { number } => format!("/{number}/start_diameter_mm"),
            LawField::Length { number } => format!("/{number}/length_mm"),
        }
    }
}

/// Of a modification that is given on a grid.
impl Field<ReliefReason> for ReliefField {
    fn pointer(&self) -> String {
        match self {
            ReliefField::Whole => String::new(),
            ReliefField::Profile => "/profile/values".to_owned(),
            ReliefField::ProfileValue { index } => format!("/profile/values/{index}"),
            ReliefField::Positions => "/face_width_positions_mm".to_owned(),
            ReliefField::Position { index } => format!("/face_width_positions_mm/{index}"),
            ReliefField::Relief => "/relief_um".to_owned(),
            ReliefField::ReliefRow { row } => format!("/relief_um/{row}"),
            ReliefField::ReliefValue { row, column } => format!("/relief_um/{row}/{column}"),
        }
    }
}

impl Field<GridReason> for GridField {
    fn pointer(&self) -> String {
        match self {
            GridField::Profile => "/profile/values".to_owned(),
            GridField::ProfileValue { index } => format!("/profile/values/{index}"),
            GridField::Positions => "/face_width_positions_mm".to_owned(),
            GridField::Position { index } => format!("/face_width_positions_mm/{index}"),
            GridField::Tooth => "/tooth".to_owned(),
        }
    }

    fn detail(&self, reason: &GridReason) -> String {
        match reason {
            GridReason::NoInvolute(found) => no_involute(found),
            other => other.to_string(),
        }
    }
}

impl Field<MeasureReason> for MeasureField {
    fn pointer(&self) -> String {
        match self {
            MeasureField::BallRadius => "/probe_radius_mm".to_owned(),
            MeasureField::Reach => "/reach_mm".to_owned(),
            MeasureField::Point { index } => format!("/points/{index}"),
            MeasureField::Tooth { index } => format!("/teeth/{index}"),
        }
    }
}

/// Of the object that holds a grid of deviations.
impl Field<deviation::TopographyReason> for deviation::TopographyField {
    fn pointer(&self) -> String {
        use deviation::TopographyField::*;
        match self {
            Tooth => "/tooth".to_owned(),
            RollLengths => "/roll_length_mm".to_owned(),
            RollLength { index } => format!("/roll_length_mm/{index}"),
            Positions => "/z_mm".to_owned(),
            Position { index } => format!("/z_mm/{index}"),
            Deviations => "/deviation_um".to_owned(),
            Row { row } => format!("/deviation_um/{row}"),
            Deviation { row, column } => format!("/deviation_um/{row}/{column}"),
        }
    }

    fn detail(&self, reason: &deviation::TopographyReason) -> String {
        match reason {
            deviation::TopographyReason::Rows { rows, roll_lengths } => {
                format!("{}, but {roll_lengths} would match roll_length_mm", counted(*rows, "row", "rows"))
            }
            deviation::TopographyReason::Columns { given, positions } => {
                format!("{}, but {positions} would match z_mm", entries(*given))
            }
            other => other.to_string(),
        }
    }
}

/// Of the object `borders`.
impl Field<BorderReason> for BorderField {
    fn pointer(&self) -> String {
        match self {
            BorderField::Whole => String::new(),
            BorderField::Profile => "/diameter_range_mm".to_owned(),
            BorderField::Face => "/z_range_mm".to_owned(),
        }
    }
}

impl Field<RegistrationReason> for RegistrationField {
    fn pointer(&self) -> String {
        match self {
            RegistrationField::Motions => "/registration/motions".to_owned(),
            RegistrationField::Motion { index } => format!("/registration/motions/{index}"),
            RegistrationField::Pivot => "/registration/pivot_z_mm".to_owned(),
            RegistrationField::Teeth => "/teeth".to_owned(),
            RegistrationField::Points => "/points".to_owned(),
            RegistrationField::Point { index } => format!("/points/{index}"),
            RegistrationField::Weights => "/weight".to_owned(),
            RegistrationField::Weight { index } => format!("/weight/{index}"),
        }
    }

    fn detail(&self, reason: &RegistrationReason) -> String {
        match reason {
            RegistrationReason::TeethContradict(share) => format!(
                "the teeth contradict each other: however the part is turned, at most {} % of the points lie on the \
                 teeth that they are said to be of. Count teeth clockwise from 1, or leave `teeth` out",
                Shown((100.0 * share).round())
            ),
            RegistrationReason::TurnedOn(count) => format!(
                "the points lie {} from the teeth that they are said to be of, and `rotation` is not among the \
                 motions: free it, or correct the teeth",
                pitches(*count)
            ),
            other => other.to_string(),
        }
    }
}

/// The name of a limit within those of a request.
fn limit(field: ToleranceField) -> &'static str {
    match field {
        ToleranceField::Class => "class",
        ToleranceField::ProfileSlope => "profile_slope_um",
        ToleranceField::HelixSlope => "helix_slope_um",
        ToleranceField::ProfileCrowning => "profile_crowning_um",
        ToleranceField::HelixCrowning => "helix_crowning_um",
        ToleranceField::Twist => "twist_um",
        ToleranceField::ProfileForm => "profile_form_um",
        ToleranceField::HelixForm => "helix_form_um",
        ToleranceField::ProfileTotal => "profile_total_um",
        ToleranceField::HelixTotal => "helix_total_um",
    }
}

/// The settings of an evaluation, of the whole request.
pub fn setting(field: SettingField) -> String {
    let name = match field {
        SettingField::ProfileRange => "profile_diameter_range_mm",
        SettingField::ProfileRangeEnd { index } => return format!("/evaluation/profile_diameter_range_mm/{index}"),
        SettingField::TipRelief => "tip_relief_diameter_range_mm",
        SettingField::TipReliefEnd { index } => return format!("/evaluation/tip_relief_diameter_range_mm/{index}"),
        SettingField::ProfileReference => "profile_reference",
        SettingField::ProfileReferenceLength => "profile_reference_length_mm",
        SettingField::HelixRange => "helix_range_mm",
        SettingField::HelixReferenceLength => "helix_reference_length_mm",
        SettingField::DeviationSign => "deviation_sign",
        SettingField::Level => "level",
        SettingField::Limit(field) => return format!("/evaluation/tolerance_limits/{}", limit(field)),
    };
    format!("/evaluation/{name}")
}

impl Field<TraceReason> for TraceField {
    fn pointer(&self) -> String {
        match *self {
            TraceField::Traces => "/traces".to_owned(),
            TraceField::Position { trace, kind: Kind::Profile, index } => {
                format!("/traces/{trace}/roll_length_mm/{index}")
            }
            TraceField::Position { trace, kind: Kind::Helix, index } => format!("/traces/{trace}/z_mm/{index}"),
            TraceField::Deviations { trace } => format!("/traces/{trace}/deviation_um"),
            TraceField::Deviation { trace, index } => format!("/traces/{trace}/deviation_um/{index}"),
            TraceField::Design { trace } => format!("/traces/{trace}/design_um"),
            TraceField::DesignAt { trace, index } => format!("/traces/{trace}/design_um/{index}"),
            TraceField::Setting(field) => setting(field),
            TraceField::FaceWidth => "/gear/face_width_mm".to_owned(),
        }
    }
}

impl Field<RunoutReason> for RunoutField {
    fn pointer(&self) -> String {
        match self {
            RunoutField::Readings => "/readings_um".to_owned(),
            RunoutField::Reading { index } => format!("/readings_um/{index}"),
            RunoutField::Left => "/left".to_owned(),
            RunoutField::Right => "/right".to_owned(),
        }
    }
}

/// Where the numbers of the teeth stand at `deviations`.
pub fn pitch(field: &PitchField, deviations: &str) -> String {
    match field {
        PitchField::Deviations => deviations.to_owned(),
        PitchField::Deviation { index } => format!("{deviations}/{index}"),
        PitchField::Diameter => "/diameter_mm".to_owned(),
        PitchField::Sector => "/sector".to_owned(),
    }
}

impl Field<PitchReason> for PitchField {
    fn pointer(&self) -> String {
        pitch(self, "/index_deviation_um")
    }
}

impl Field<SurfaceReason> for SurfaceField {
    fn pointer(&self) -> String {
        match self {
            SurfaceField::Profile => "/profile".to_owned(),
            SurfaceField::ProfileAt { index } => format!("/profile/{index}"),
            SurfaceField::Positions => "/z_mm".to_owned(),
            SurfaceField::Position { index } => format!("/z_mm/{index}"),
            SurfaceField::Deviations => "/deviation_um".to_owned(),
            SurfaceField::Deviation { index } => format!("/deviation_um/{index}"),
            SurfaceField::Valid => "/valid".to_owned(),
            SurfaceField::ProfileRange => "/profile_range".to_owned(),
            SurfaceField::ProfileRangeEnd { index } => format!("/profile_range/{index}"),
            SurfaceField::HelixRange => "/helix_range_mm".to_owned(),
            SurfaceField::Border => "/border_percent".to_owned(),
            SurfaceField::BorderRoot => "/border_percent/root".to_owned(),
            SurfaceField::BorderTip => "/border_percent/tip".to_owned(),
            SurfaceField::BorderToe => "/border_percent/toe".to_owned(),
            SurfaceField::BorderHeel => "/border_percent/heel".to_owned(),
            SurfaceField::Limit(field) => format!("/tolerance_limits/{}", limit(*field)),
        }
    }

    fn detail(&self, reason: &SurfaceReason) -> String {
        match reason {
            SurfaceReason::NoInvolute(found) => no_involute(found),
            other => other.to_string(),
        }
    }
}

impl Field<CorrectionReason> for CorrectionField {
    fn pointer(&self) -> String {
        match self {
            CorrectionField::Deviations => "/deviation_um".to_owned(),
            CorrectionField::Deviation { index } => format!("/deviation_um/{index}"),
            CorrectionField::Targets => "/target/deviation_um".to_owned(),
            CorrectionField::Target { index } => format!("/target/deviation_um/{index}"),
            CorrectionField::Weights => "/weight".to_owned(),
            CorrectionField::Weight { index } => format!("/weight/{index}"),
            CorrectionField::Settings => "/sensitivity/settings".to_owned(),
            CorrectionField::Setting { index } => format!("/sensitivity/settings/{index}"),
            CorrectionField::Matrix => "/sensitivity/matrix".to_owned(),
            CorrectionField::Entry { row, column } => format!("/sensitivity/matrix/{row}/{column}"),
            CorrectionField::Limits => "/limits".to_owned(),
            CorrectionField::Limit { setting, limit } => {
                let limit = match limit {
                    LimitField::Min => "min",
                    LimitField::Max => "max",
                    LimitField::Increment => "increment",
                };
                format!("/limits/{}/{limit}", escape(setting))
            }
            CorrectionField::Traces => "/trace".to_owned(),
            CorrectionField::Absolute => "/absolute".to_owned(),
            CorrectionField::NoiseSigma => "/noise_sigma_um".to_owned(),
            CorrectionField::CoefficientNormLimit => "/coefficient_norm_limit".to_owned(),
            CorrectionField::ResponseUncertainty => "/response_uncertainty".to_owned(),
            CorrectionField::KeepWithin => "/keep_within".to_owned(),
        }
    }

    fn detail(&self, reason: &CorrectionReason) -> String {
        match reason {
            CorrectionReason::TracesWithDatum => {
                "traces that have a zero each have no common one: leave it out, or `trace`".to_owned()
            }
            other => other.to_string(),
        }
    }
}

/// A refused fit of a flank: by the table, or where `fit` places a path of the fit.
pub fn refused<F, R>(error: Refused<F, R>, fit: impl Fn(&str) -> String) -> Problem
where
    F: Field<R> + std::fmt::Debug,
    R: std::fmt::Debug + std::fmt::Display,
{
    match error {
        Refused::Invalid(faults) => Problem::invalid(faults),
        Refused::Fit(error) => Problem::of_fit(error, fit),
    }
}

#[cfg(test)]
mod tests {
    use super::degrees;

    #[test]
    fn angles_are_shown_in_few_digits() {
        for sent in [1000.0_f64, 20.0, 91.3, 0.1, -45.123_456] {
            assert_eq!(degrees(sent.to_radians()).to_string(), sent.to_string());
        }
        // radians that no number of degrees of sixteen digits gives
        let odd = 17.453_292_519_943_3_f64;
        assert!(degrees(odd).to_string().len() <= 16, "{}", degrees(odd));
        assert_eq!(degrees(f64::NAN).to_string(), "NaN");
    }
}
