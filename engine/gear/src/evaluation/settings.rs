//! Settings of an evaluation: ranges, reference lengths, signs, rules. Nothing is guessed:
//! what the request leaves open is an error.

use super::super::{
    Gear, Side,
    data::{LEAST_LENGTH, MOST_LENGTH},
    trace::{Direction, Kind},
};
use super::{against::Against, band::Band, limits::SidedLimits};
use flankfit_estimation::spec::DEFAULT_LEVEL;
use flankfit_numerics::{
    check::Faults,
    words::{Shown, rounded},
};

/// The sign of deviations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum DeviationSign {
    /// Positive where material protrudes from the flank.
    #[default]
    Material,
    /// Profiles as `material`; helices positive where the flank is turned counterclockwise, so
    /// that a rising trace deviates towards the right hand on both flanks.
    Din,
    /// Positive where the flank is turned clockwise, on every trace, as some curve files hold
    /// it.
    Clockwise,
}

impl DeviationSign {
    /// Factor by which a posted deviation is multiplied so that material counts positive.
    pub fn to_material(self, kind: Kind, side: Side) -> f64 {
        match (self, kind) {
            (DeviationSign::Material, _) | (DeviationSign::Din, Kind::Profile) => 1.0,
            (DeviationSign::Din, Kind::Helix) => side.sign(),
            (DeviationSign::Clockwise, _) => -side.sign(),
        }
    }
}

/// The sign of slopes. Profile slopes are positive under `din` and `vdi` where material grows
/// from root to tip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum SlopeSign {
    /// Helix slopes are positive where the helix deviates towards the right hand, on both
    /// flanks.
    #[default]
    Din,
    /// Helix slopes are positive where material grows with z.
    Vdi,
    /// Slopes of the numbers as they were posted, towards the tip and towards greater z.
    AsGiven,
}

impl SlopeSign {
    /// Factor by which the slope of material is multiplied.
    pub fn of_material(self, given: DeviationSign, kind: Kind, side: Side) -> f64 {
        match (self, kind) {
            (SlopeSign::Din, Kind::Helix) => side.sign(),
            (SlopeSign::Din, Kind::Profile) | (SlopeSign::Vdi, _) => 1.0,
            (SlopeSign::AsGiven, _) => given.to_material(kind, side),
        }
    }
}

/// Mean curve that form is taken about, and that has the slope.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum MeanCurve {
    /// The least-squares line.
    #[default]
    Line,
    /// The least-squares parabola, for crowned designs; the slope is that of its chord.
    Parabola,
}

/// Use of material outside the evaluation range (on profiles up to the tip, on helices up to both
/// ends) that protrudes more than all within. It raises the highest, never the lowest point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum PlusMaterial {
    /// Only samples of the evaluation range count.
    #[default]
    Ignored,
    /// They count in form and total deviation.
    FormAndTotal,
    /// They count in the form deviation only, as some instruments do: F may then be smaller than
    /// f_f.
    Form,
    /// They count in the total deviation only.
    Total,
}

impl PlusMaterial {
    /// Returns true if it raises the form deviation.
    pub fn in_form(self) -> bool {
        matches!(self, PlusMaterial::Form | PlusMaterial::FormAndTotal)
    }

    /// Returns true if it raises the total deviation.
    pub fn in_total(self) -> bool {
        matches!(self, PlusMaterial::Total | PlusMaterial::FormAndTotal)
    }
}

/// Use of samples that are far from their neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = TraceOutlierRule)
)]
pub enum Outliers {
    /// They count, as in the standard; a warning has the results without them.
    #[default]
    Keep,
    /// They count as undefined; a warning says where they are.
    Exclude,
}

/// Length that profile slopes are extended to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum ProfileReference {
    /// L_α, the roll length of the evaluation range.
    #[default]
    EvaluationRange,
    /// From the start of the evaluation range (its root end) up to the tip circle.
    ToTip,
}

/// Length that helix slopes are extended to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum HelixReference {
    /// The face width b.
    #[default]
    FaceWidth,
    /// L_β, the length of the evaluation range.
    EvaluationRange,
}

/// How profiles are evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileSettings {
    /// Ascending diameters, mm.
    pub diameters: [f64; 2],
    /// Length that slopes are extended to.
    pub reference: ProfileReference,
    /// Length in its place, mm of roll length.
    pub reference_length: Option<f64>,
    /// Curve that represents the mean profile.
    pub mean: MeanCurve,
    /// Use of plus material outside the evaluation range.
    pub plus_material: PlusMaterial,
    /// Diameters between which the tip relief lies, mm.
    pub tip_relief: Option<[f64; 2]>,
}

impl ProfileSettings {
    /// The defaults on a range of diameters.
    pub fn on(diameters: [f64; 2]) -> Self {
        let (reference, mean, plus_material) = Default::default();
        ProfileSettings { diameters, reference, reference_length: None, mean, plus_material, tip_relief: None }
    }
}

/// How helices are evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HelixSettings {
    /// Ascending z, mm.
    pub range: [f64; 2],
    /// Length that slopes are extended to.
    pub reference: HelixReference,
    /// Length in its place, mm along the axis.
    pub reference_length: Option<f64>,
    /// Curve that represents the mean helix.
    pub mean: MeanCurve,
    /// Use of plus material outside the evaluation range.
    pub plus_material: PlusMaterial,
}

impl HelixSettings {
    /// The defaults on a range of z.
    pub fn on(range: [f64; 2]) -> Self {
        let (reference, mean, plus_material) = Default::default();
        HelixSettings { range, reference, reference_length: None, mean, plus_material }
    }
}

/// Everything about an evaluation but gear and traces.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Needed when there are profiles.
    pub profile: Option<ProfileSettings>,
    /// Needed when there are helices.
    pub helix: Option<HelixSettings>,
    /// How the deviations given count.
    pub given: DeviationSign,
    /// Line along which the deviations given are taken.
    pub direction: Direction,
    /// Line that figures are about.
    pub against: Against,
    /// Sign of slopes.
    pub sign: SlopeSign,
    /// Whether tolerances are rounded before a class is found.
    pub rounding: super::super::tolerance::Rounding,
    /// Treatment of samples that deviate from their neighbours.
    pub outliers: Outliers,
    /// Whether the deviations of all traces of a flank count from one zero. Measuring machines zero
    /// each trace by itself.
    pub traces_share_zero: bool,
    /// Level of confidence intervals, between 0.5 and 1.
    pub level: f64,
    /// Limits that figures have to conform to.
    pub limits: SidedLimits,
    /// Bands that traces must lie in (K-charts).
    pub bands: Vec<Band>,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            profile: None,
            helix: None,
            given: DeviationSign::default(),
            direction: Direction::default(),
            against: Against::default(),
            sign: SlopeSign::default(),
            rounding: Default::default(),
            outliers: Outliers::default(),
            traces_share_zero: false,
            level: DEFAULT_LEVEL,
            limits: SidedLimits::default(),
            bands: Vec::new(),
        }
    }
}

/// Settings for traces of one kind, in the coordinate of their samples (roll length or
/// z, mm); returned as they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Lower end of the evaluation range.
    pub low: f64,
    /// Upper end of the evaluation range.
    pub high: f64,
    /// Length that slopes are extended to.
    pub reference: f64,
    /// +1 where slopes count towards greater coordinates, −1 on internal gears' profiles, whose tip
    /// lies at smaller roll lengths.
    pub sense: f64,
    /// How far samples are looked at for plus material.
    pub zone: [f64; 2],
    /// Curve that represents the mean trace.
    pub mean: MeanCurve,
    /// Use of plus material outside the evaluation range.
    pub plus_material: PlusMaterial,
    /// Range of the tip relief, in ascending roll length.
    pub tip_relief: Option<[f64; 2]>,
}

impl Window {
    /// Length of the evaluation range.
    pub fn length(&self) -> f64 {
        self.high - self.low
    }

    /// Returns the window of profiles.
    pub fn of_profile(gear: &Gear, asked: &ProfileSettings) -> Result<Self, Faults> {
        let [low, high] = roll_lengths(gear, asked.diameters, PROFILE_RANGE)?;
        ascending(PROFILE_RANGE, asked.diameters, high - low)?;
        let relief = asked.tip_relief.map(|diameters| {
            const PATH: &str = "tip_relief_diameter_range_mm";
            let [from, to] = roll_lengths(gear, diameters, PATH)?;
            ascending(PATH, diameters, to - from)?;
            Ok::<_, Faults>([from, to])
        });
        let tip_relief = relief.transpose()?;
        let tip = gear.roll_length(2.0 * gear.tip_radius());
        let internal = gear.outward() < 0.0;
        let reference = match (asked.reference_length, asked.reference) {
            (Some(length), _) => given(Kind::Profile, length)?,
            (None, ProfileReference::EvaluationRange) => high - low,
            (None, ProfileReference::ToTip) => {
                let length = tip.map_or(f64::NAN, |tip| if internal { high - tip } else { tip - low });
                if !(length > 0.0) {
                    let path = if tip.is_some() { PROFILE_RANGE } else { "profile_reference" };
                    let diameter = rounded(2.0 * gear.tip_radius(), 7);
                    return Err(Faults::one(
                        path,
                        format_args!(
                            "the tip circle of {diameter} mm has no roll length above the start of the evaluation \
                                range"
                        ),
                    ));
                }
                length
            }
        };
        // outside the tip there is no flank; on internal gears whose tip lies within the base
        // circle it ends there
        let zone = match tip {
            Some(tip) if internal => [tip.min(low), high],
            None if internal => [0.0, high],
            Some(tip) => [low, tip.max(high)],
            None => [low, high],
        };
        let (mean, plus_material) = (asked.mean, asked.plus_material);
        Ok(Window { low, high, reference, sense: gear.outward(), zone, mean, plus_material, tip_relief })
    }

    /// Returns the window of helices.
    pub fn of_helix(gear: &Gear, asked: &HelixSettings) -> Result<Self, Faults> {
        let [low, high] = asked.range;
        ascending("helix_range_mm", asked.range, high - low)?;
        let reference = match (asked.reference_length, asked.reference) {
            (Some(length), _) => given(Kind::Helix, length)?,
            (None, HelixReference::EvaluationRange) => high - low,
            (None, HelixReference::FaceWidth) => gear.data().face_width.ok_or_else(|| {
                let message = "the gear has no face width to extend slopes to; give it, or the length";
                Faults::one(reference_length(Kind::Helix), message)
            })?,
        };
        let zone = [f64::NEG_INFINITY, f64::INFINITY];
        let (mean, plus_material) = (asked.mean, asked.plus_material);
        Ok(Window { low, high, reference, sense: 1.0, zone, mean, plus_material, tip_relief: None })
    }
}

/// Path to the diameters of the evaluation range of profiles.
const PROFILE_RANGE: &str = "profile_diameter_range_mm";

/// Path to the length that slopes of a kind of trace are extended to.
pub(super) fn reference_length(kind: Kind) -> &'static str {
    match kind {
        Kind::Profile => "profile_reference_length_mm",
        Kind::Helix => "helix_reference_length_mm",
    }
}

/// Roll lengths of the two diameters at `path`.
fn roll_lengths(gear: &Gear, diameters: [f64; 2], path: &str) -> Result<[f64; 2], Faults> {
    let mut faults = Faults::default();
    let mut ends = [0.0; 2];
    for (k, &diameter) in diameters.iter().enumerate() {
        match gear.roll_length(diameter).filter(|l| l.is_finite()) {
            Some(length) => ends[k] = length,
            None => {
                let [diameter, base] = [diameter, 2.0 * gear.base_radius()].map(|x| rounded(x, 7));
                faults.push(
                    format_args!("{path}[{k}]"),
                    format_args!("{diameter} mm is not a diameter on the involute, which starts at {base} mm"),
                );
            }
        }
    }
    faults.into_result(ends)
}

/// `length` is that of the range in the coordinate of the samples.
fn ascending(path: &str, range: [f64; 2], length: f64) -> Result<(), Faults> {
    if length >= LEAST_LENGTH && range.iter().all(|end| end.abs() <= MOST_LENGTH) {
        return Ok(());
    }
    let [from, to] = range.map(Shown);
    Err(Faults::one(
        path,
        format_args!("{from} to {to} mm is not an ascending range (of a µm at least, and within a kilometre)"),
    ))
}

fn given(kind: Kind, length: f64) -> Result<f64, Faults> {
    if length > 0.0 && length <= MOST_LENGTH {
        return Ok(length);
    }
    let length = Shown(length);
    Err(Faults::one(
        reference_length(kind),
        format_args!("{length} is not a length above 0 mm (and up to a kilometre)"),
    ))
}
