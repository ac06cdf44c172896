//! Pitch deviations of one flank all around the gear.
//!
//! Teeth are numbered 1 … z in the direction in which deviations count positive; the index
//! deviation δᵢ is the arc, in µm on the measuring circle, by which flank i lies ahead of its place
//! relative to the first one there is. Of these: single pitch deviations `f_pi = δᵢ − δᵢ₋₁` (of the
//! pitch that ends at flank i, all around: `f_p1 = δ₁ − δ_z`), `f_p` = greatest |f_pi|, `F_p` =
//! range of δ, `f_u` = greatest |f_pi − f_pi₋₁|.
//!
//! Over k pitches the editions of ISO 1328-1 differ. Annex D of 2013: `F_pk` = greatest range of δ
//! within any k pitches (k + 1 flanks), and `F_pSk` = greatest |δ at the end − δ at the start| of
//! the consecutive sectors of k pitches that begin at the first tooth. 1995: `F_pk` = greatest
//! |δᵢ₊ₖ − δᵢ|, which testers print as F_pz/8 for k = z/8.
//!
//! A tooth that was not measured leaves out what needs it. What is left is then a lower bound of
//! the gear's value: [`Pitch::complete`] is false and no class is given.

use std::{collections::VecDeque, f64::consts::TAU};

use super::{pitch_limits::Held, warning::PitchWarning};
use crate::{
    Gear, Side,
    data::MOST_LENGTH,
    tolerance::{Characteristic, Rounding, Tolerances, numbered},
    trace::MOST_DEVIATION,
};
use flankfit_estimation::inference::Conformity;
use flankfit_numerics::{
    check::Faults,
    words::{Shown, entries, rounded},
};

/// Measured values: one number per tooth, NaN where there is none.
#[derive(Clone, Debug, PartialEq)]
pub enum PitchMeasured {
    /// Index deviations, µm on the measuring circle.
    Index(Vec<f64>),
    /// Angles of the flanks, rad in the direction of counting, from anywhere.
    Angles(Vec<f64>),
    /// Single pitch deviations f_pi, µm on the measuring circle. Their sum all around is 0 by
    /// definition; what is left of it is taken off evenly.
    Single(Vec<f64>),
}

/// Settings of an evaluation of pitch deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PitchSettings {
    /// Flank that was measured.
    pub side: Side,
    /// Diameter of the measuring circle, mm; by default the reference circle. Angles become arcs
    /// there.
    pub diameter: Option<f64>,
    /// k of F_pk and F_pSk, 1 to z − 1; by default z/8, rounded.
    pub sector: Option<usize>,
    /// Whether tolerances are rounded before a class is found.
    pub rounding: Rounding,
}

/// A value and its tooth, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = ToothExtreme)
)]
pub struct Extreme {
    /// The value with its sign.
    pub value_um: f64,
    /// Number of the tooth from 1, in the order of counting.
    pub tooth: usize,
}

/// Pitch deviations of a flank.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = FlankPitch)
)]
pub struct Pitch {
    /// Flank that was measured.
    pub flank: Side,
    /// Diameter of the measuring circle.
    pub diameter_mm: f64,
    /// δᵢ about the first tooth that was measured; of single pitches only if none is missing.
    pub index_deviation_um: Vec<Option<f64>>,
    /// f_pi, the deviation of the pitch that ends at each flank; `null` if undefined.
    pub single_pitch_deviation_um: Vec<Option<f64>>,
    /// f_p: the single pitch deviation of greatest amount, with its sign.
    pub single_pitch: Option<Extreme>,
    /// R_p: the greatest single pitch deviation minus the least.
    pub single_pitch_range_um: Option<f64>,
    /// F_p: total cumulative pitch deviation, the range of the index deviations.
    pub cumulative_pitch_um: Option<f64>,
    /// Number of pitches of a sector.
    pub k: Option<usize>,
    /// F_pk of ISO 1328-1:2013, Annex D: the greatest range of the index deviations within any k
    /// pitches (k + 1 flanks), at the tooth where the sector ends.
    pub sector_pitch_2013: Option<Extreme>,
    /// F_pSk of ISO 1328-1:2013, Annex D: of the consecutive sectors of k pitches that begin at
    /// tooth 1, the sum of greatest amount, at the tooth where the sector ends. Pitches after the
    /// last whole sector are omitted.
    pub sector_sum_2013: Option<Extreme>,
    /// F_pk of ISO 1328-1:1995: the sum of any k pitches of greatest amount, at the tooth where the
    /// sector ends. Testers print its amount as F_pz/8.
    pub sector_pitch_1995: Option<Extreme>,
    /// f_u: the greatest difference of neighbouring pitches, at the later of the two.
    pub adjacent_pitch_difference: Option<Extreme>,
    /// Sum of the single pitches, as they were posted.
    pub closure_um: Option<f64>,
    /// Number of teeth that were not measured.
    pub missing: usize,
    /// True if every tooth was measured.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub complete: bool,
    /// Classes of f_p and F_p.
    pub class: PitchClasses,
    /// Limits of the single pitch deviations.
    pub single_pitch_limits_um: Option<[f64; 2]>,
    /// True if every single pitch deviation lies within its limits, as measured; present with
    /// limits. If teeth were not measured it is false or absent.
    pub single_pitch_within: Option<bool>,
    /// Conformity of the single pitch nearest to its limits. A gear with a pitch at its limit
    /// conforms in at most one measurement of twenty, and fails to conform more often, the more
    /// pitches are at their limits (docs/explanation/intervals.md). Present with limits and an
    /// uncertainty, if no tooth is missing.
    pub single_pitch_conformity: Option<Conformity>,
    /// Limits of F_p.
    pub cumulative_pitch_limits_um: Option<[f64; 2]>,
    /// True if F_p lies within its limits, likewise.
    pub cumulative_pitch_within: Option<bool>,
    /// Conformity of F_p, likewise.
    pub cumulative_pitch_conformity: Option<Conformity>,
    /// Warnings.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub warnings: Vec<PitchWarning>,
}

/// Classes 1 to 11 of ISO 1328-1:2013. Those coarser than 11 are absent and named by
/// `coarser_than_11`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct PitchClasses {
    /// Class of f_p; absent without value or tolerance.
    pub single_pitch: Option<u8>,
    /// Class of F_p; absent without value or tolerance.
    pub cumulative_pitch: Option<u8>,
    /// Names of the two above that exceed even class 11.
    #[cfg_attr(feature = "contract", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub coarser_than_11: Vec<String>,
}

impl Pitch {
    /// Adds the comparison of f_p and F_p with their limits.
    pub fn hold(&mut self, single: Option<Held>, cumulative: Option<Held>) {
        self.single_pitch_limits_um = single.map(|held| held.limits_um);
        self.single_pitch_within = single.and_then(|held| held.within);
        self.single_pitch_conformity = single.and_then(|held| held.conformity);
        self.cumulative_pitch_limits_um = cumulative.map(|held| held.limits_um);
        self.cumulative_pitch_within = cumulative.and_then(|held| held.within);
        self.cumulative_pitch_conformity = cumulative.and_then(|held| held.conformity);
    }
}

/// Evaluates pitch deviations.
///
/// ```
/// use flankfit_gear::{
///     Gear, GearData, Side,
///     evaluation::pitch::{PitchMeasured, PitchSettings, pitch},
///     tolerance::Rounding,
/// };
///
/// // Flanks 0, 3, 1 and −2 µm off their places, all around 20 teeth: single pitches of 3, −2, −3
/// // and 2, and 5 between the highest and the lowest.
/// let gear = Gear::new(GearData::spur(20, 2.0))?;
/// let index = [0.0, 3.0, 1.0, -2.0].into_iter().cycle().take(20).collect();
/// let (side, rounding) = (Side::Left, Rounding::default());
/// let settings = PitchSettings { side, diameter: None, sector: None, rounding };
/// let found = pitch(&gear, &PitchMeasured::Index(index), &settings)?;
/// assert_eq!(found.cumulative_pitch_um, Some(5.0));
/// assert_eq!(found.single_pitch.unwrap().value_um.abs(), 3.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn pitch(gear: &Gear, measured: &PitchMeasured, settings: &PitchSettings) -> Result<Pitch, Faults> {
    let teeth = gear.data().teeth as usize;
    let diameter = settings.diameter.unwrap_or(2.0 * gear.reference_radius());
    let sector = settings.sector.or_else(|| (teeth > 1).then(|| ((teeth as f64 / 8.0).round() as usize).max(1)));
    let given = check(teeth, diameter, sector, measured)?;
    let missing = given.iter().filter(|d| d.is_nan()).count();
    let mut warnings = Vec::new();
    let mut closure = None;
    let (index, single) = match measured {
        PitchMeasured::Index(_) => of_index(given.to_vec()),
        PitchMeasured::Angles(_) => {
            let arcs = arcs(given, diameter);
            let half = 5e2 * std::f64::consts::PI * diameter / teeth as f64;
            if let Some(i) = arcs.iter().position(|arc| arc.abs() > half) {
                let arc = rounded(arcs[i], 4);
                return Err(Faults::one(
                    format_args!("angle_deg[{i}]"),
                    format_args!(
                        "the flank is {arc} µm from its nominal position, more than half a pitch: give angles in the \
                         direction in which teeth are counted"
                    ),
                ));
            }
            of_index(arcs)
        }
        PitchMeasured::Single(_) => {
            let sum = given.iter().sum::<f64>();
            closure = (missing == 0).then_some(sum);
            of_single(given, closure)
        }
    };
    if let Some(sum) = closure.filter(|sum| sum.abs() > CLOSURE * teeth as f64) {
        warnings.push(PitchWarning::PitchesDoNotClose { sum_um: sum });
    }
    if missing > 0 {
        warnings.push(PitchWarning::MissingTeeth { missing, teeth });
    }
    let complete = missing == 0;
    let single_pitch = greatest(single.iter().enumerate().filter_map(|(i, f)| Some((i, (*f)?))));
    let cumulative = range(&index);
    let classified = match (complete, Tolerances::new(gear)) {
        (false, _) => [None; 2],
        (true, Ok(tolerances)) => {
            let class = |of, value: Option<f64>| tolerances.class(of, value?, settings.rounding);
            [
                class(Characteristic::SinglePitch, single_pitch.map(|f| f.value_um)),
                class(Characteristic::CumulativePitch, cumulative),
            ]
        }
        (true, Err(out)) => {
            warnings.push(PitchWarning::OutsideTheStandard(out));
            [None; 2]
        }
    };
    let difference =
        |values: &[Option<f64>], i: usize, back: usize| Some((i, values[i]? - values[(i + teeth - back) % teeth]?));
    let sums = |ends: &mut dyn Iterator<Item = usize>, k| greatest(ends.filter_map(|i| difference(&index, i, k)));
    let sector_pitch_2013 = sector.and_then(|k| widest_sector(&index, k));
    let sector_sum_2013 = sector.and_then(|k| sums(&mut (1..=teeth / k).map(|n| n * k % teeth), k));
    let sector_pitch_1995 = sector.and_then(|k| sums(&mut (0..teeth), k));
    let adjacent = (teeth > 1).then(|| greatest((0..teeth).filter_map(|i| difference(&single, i, 1)))).flatten();
    let named = [("single_pitch", classified[0]), ("cumulative_pitch", classified[1])];
    let ([of_single, of_cumulative], coarser_than_11) = numbered(named);
    Ok(Pitch {
        flank: settings.side,
        diameter_mm: diameter,
        single_pitch,
        single_pitch_range_um: range(&single),
        cumulative_pitch_um: cumulative,
        k: sector,
        sector_pitch_2013,
        sector_sum_2013,
        sector_pitch_1995,
        adjacent_pitch_difference: adjacent,
        closure_um: closure,
        missing,
        complete,
        class: PitchClasses { single_pitch: of_single, cumulative_pitch: of_cumulative, coarser_than_11 },
        single_pitch_limits_um: None,
        single_pitch_within: None,
        single_pitch_conformity: None,
        cumulative_pitch_limits_um: None,
        cumulative_pitch_within: None,
        cumulative_pitch_conformity: None,
        index_deviation_um: index,
        single_pitch_deviation_um: single,
        warnings,
    })
}

/// Returns R_s: variation of the tooth thickness, µm along the measuring circle, from the flanks of
/// both sides counted in one direction. Teeth without both flanks are skipped; `None` if no tooth
/// has both.
pub fn thickness_variation(left: &Pitch, right: &Pitch) -> Option<f64> {
    let thickness: Vec<_> = left
        .index_deviation_um
        .iter()
        .zip(&right.index_deviation_um)
        .map(|(left, right)| Some((*left)? - (*right)?))
        .collect();
    range(&thickness)
}

/// No angle is larger, rad: 16,000 turns, of which a double still resolves 1e-11 rad.
const MOST_ANGLE: f64 = 1e5;
/// Rounding to a tenth of a µm leaves at most this much a tooth.
const CLOSURE: f64 = 0.05;

type Deviations = (Vec<Option<f64>>, Vec<Option<f64>>);

fn of_index(given: Vec<f64>) -> Deviations {
    let teeth = given.len();
    let first = given.iter().copied().find(|d| !d.is_nan()).unwrap_or_default();
    let index: Vec<Option<f64>> = given.iter().map(|d| (!d.is_nan()).then_some(d - first)).collect();
    let single = (0..teeth).map(|i| Some(index[i]? - index[(i + teeth - 1) % teeth]?)).collect();
    (index, single)
}

/// With a gap there is nothing that index deviations could be added up across.
fn of_single(given: &[f64], closure: Option<f64>) -> Deviations {
    let Some(sum) = closure else {
        let single = given.iter().map(|f| (!f.is_nan()).then_some(*f)).collect();
        return (vec![None; given.len()], single);
    };
    let even = sum / given.len() as f64;
    let single: Vec<f64> = given.iter().map(|f| f - even).collect();
    let mut index = vec![Some(0.0)];
    let mut reached = 0.0;
    for f in &single[1..] {
        reached += f;
        index.push(Some(reached));
    }
    (index, single.into_iter().map(Some).collect())
}

/// Arcs by which the flanks lie ahead of their places, about the first one there is.
fn arcs(angles: &[f64], diameter: f64) -> Vec<f64> {
    let teeth = angles.len() as f64;
    let Some(first) = angles.iter().position(|a| !a.is_nan()) else { return angles.to_vec() };
    let beyond = |i: usize| {
        let turn = angles[i] - angles[first] - TAU * (i - first) as f64 / teeth;
        // a full turn more or less is the same flank
        let turn = turn - TAU * (turn / TAU).round();
        1e3 * 0.5 * diameter * turn
    };
    (0..angles.len()).map(|i| if angles[i].is_nan() { f64::NAN } else { beyond(i) }).collect()
}

/// Returns the greatest value; among equal amounts that of the first tooth.
fn greatest(values: impl Iterator<Item = (usize, f64)>) -> Option<Extreme> {
    values.fold(None, |best: Option<Extreme>, (i, value)| match best {
        Some(best) if best.value_um.abs() >= value.abs() => Some(best),
        _ => Some(Extreme { value_um: value, tooth: i + 1 }),
    })
}

/// Returns the greatest range within k pitches. Sectors with a tooth that was not measured are
/// skipped.
fn widest_sector(index: &[Option<f64>], k: usize) -> Option<Extreme> {
    let teeth = index.len();
    // the flanks that may still be the highest, and the lowest, of a sector, by steps around the
    // gear
    let (mut high, mut low) = (VecDeque::<(usize, f64)>::new(), VecDeque::<(usize, f64)>::new());
    let mut in_a_row = 0;
    let mut ranges = vec![None; teeth];
    for step in 0..teeth + k {
        let Some(value) = index[step % teeth] else {
            high.clear();
            low.clear();
            in_a_row = 0;
            continue;
        };
        in_a_row += 1;
        for (ends, sign) in [(&mut high, 1.0), (&mut low, -1.0)] {
            while ends.back().is_some_and(|(_, other)| sign * other <= sign * value) {
                ends.pop_back();
            }
            ends.push_back((step, value));
            while ends.front().is_some_and(|(first, _)| first + k < step) {
                ends.pop_front();
            }
        }
        if in_a_row > k {
            ranges[step % teeth] = Some(high[0].1 - low[0].1);
        }
    }
    greatest(ranges.into_iter().enumerate().filter_map(|(i, range)| Some((i, range?))))
}

fn range(values: &[Option<f64>]) -> Option<f64> {
    let ends = values.iter().flatten().fold(None, |ends: Option<[f64; 2]>, &v| {
        Some(ends.map_or([v, v], |[least, most]| [least.min(v), most.max(v)]))
    });
    ends.map(|[least, most]| most - least)
}

fn check(teeth: usize, diameter: f64, sector: Option<usize>, measured: &PitchMeasured) -> Result<&[f64], Faults> {
    let (path, unit, most, given) = match measured {
        PitchMeasured::Index(given) => ("index_deviation_um", "µm", MOST_DEVIATION, given),
        PitchMeasured::Angles(given) => ("angle_deg", "rad", MOST_ANGLE, given),
        PitchMeasured::Single(given) => ("single_pitch_um", "µm", MOST_DEVIATION, given),
    };
    let mut faults = Faults::default();
    if given.len() != teeth {
        faults.push(path, count(given.len(), teeth));
    }
    for (index, &value) in given.iter().enumerate() {
        if value.abs() > most {
            faults.push(format_args!("{path}[{index}]"), exceeds(value, most, unit));
        }
    }
    if !given.is_empty() && given.iter().all(|d| d.is_nan()) {
        faults.push(path, "no tooth was measured");
    }
    if !(diameter > 0.0 && diameter <= MOST_LENGTH) {
        let diameter = Shown(diameter);
        faults.push("diameter_mm", format_args!("{diameter} is not a diameter above 0 mm (and up to a kilometre)"));
    }
    if let Some(k) = sector.filter(|k| !(1..teeth).contains(k)) {
        let most = teeth.saturating_sub(1);
        faults.push("sector", format_args!("{k} pitches; a sector has 1 to {most}"));
    }
    faults.into_result(given.as_slice())
}

/// The message of a list that has not one number for each tooth.
pub(super) fn count(given: usize, teeth: usize) -> String {
    format!("{}, but the gear has {teeth} teeth", entries(given))
}

/// The message of a number outside the range of measurements.
pub(super) fn exceeds(value: f64, most: f64, unit: &str) -> String {
    format!("{} {unit} exceeds {} {unit}", Shown(value), Shown(most))
}
