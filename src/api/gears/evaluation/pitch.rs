//! Pitch deviations of both flanks, and run-out.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{
    conformity::ConformityBody,
    pitch_limits::{HeldBody, PitchLimitsBody, PitchUncertaintyBody},
    request::RoundingName,
    runout::RunoutBody,
    thickness::ToothThicknessBody,
};
use crate::{
    api::{
        built::Built,
        faults::{Faults, moved},
        gears::{
            gear::GearBody,
            notice::NoticeBody,
            of_iteration::{ToothOf, refuse_others},
            plausibility::implausible_pitches,
            requirements::RequirementsBody,
        },
        json::{gather::gathered, value::read_json, writer},
        measurand::side::SideName,
        problem::Problem,
    },
    jobs::Measurand,
};
pub use flankfit_engine::gear::evaluation::runout::Counting as CountingName;
use flankfit_engine::{
    gear::{
        Gear, Side,
        evaluation::{
            pitch::{Extreme, Pitch, PitchMeasured, PitchSettings, pitch, thickness_variation},
            runout::{Runout, from_pitches, from_readings},
        },
        tolerance::{Class, OutOfScope, Rounding, Tolerances},
    },
    numerics::check,
};

/// Where limits stand in a request.
const LIMITS: &str = "/pitch_limits";

/// Pitches of one flank or of both, readings of a run-out probe, or all of them. Teeth stand in the
/// order of counting; `null` where a tooth was not measured.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = PitchRequest)]
pub struct PitchRequestBody {
    /// May be left out where the pitches belong to a job that has it.
    pub gear: Option<GearBody>,
    pub left: Option<PitchMeasuredBody>,
    pub right: Option<PitchMeasuredBody>,
    /// Radial readings of a ball in each tooth space, outwards positive. Without them the run-out
    /// follows from the pitches of both flanks.
    pub readings_um: Option<Vec<Option<f64>>>,
    /// Diameter of the measuring circle. Default the reference circle.
    #[schema(exclusive_minimum = 0)]
    pub diameter_mm: Option<f64>,
    /// k of F_pk and F_pSk. Default an eighth of the teeth.
    #[schema(minimum = 1)]
    pub sector: Option<usize>,
    /// Which way teeth are counted. It decides which flanks bound a space: without it no run-out
    /// follows from pitches.
    pub counting: Option<CountingName>,
    /// Which tolerances decide the class. Default `rounded`.
    pub tolerances: Option<RoundingName>,
    /// What the figures must lie within. In a job those of its `requirements` take its place where
    /// it is left out.
    pub pitch_limits: Option<PitchLimitsBody>,
    /// How sure the figures are, for a decision by ISO 14253-1.
    pub standard_uncertainty_um: Option<PitchUncertaintyBody>,
    /// Whether deviations far below or above those of any gear are given in µm all the same. Until
    /// then `implausible_unit` warns of them, and the flank has no class and is held against no
    /// limits. Default false.
    pub accept_units: Option<bool>,
}

/// Where the flanks of all teeth are, in one of three forms.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = PitchMeasured)]
pub struct PitchMeasuredBody {
    /// How far each flank stands beyond its place, along the measuring circle, in the direction in
    /// which teeth are counted.
    pub index_deviation_um: Option<Vec<Option<f64>>>,
    /// Where each flank is, from anywhere, in the direction in which teeth are counted (their
    /// angles ascend, but for full turns).
    pub angle_deg: Option<Vec<Option<f64>>>,
    /// Deviation of the pitch that ends at each flank.
    pub single_pitch_um: Option<Vec<Option<f64>>>,
}

/// Pitch deviations and run-out.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = PitchEvaluation)]
pub struct PitchEvaluationBody {
    /// Which way teeth are counted; left out where it is not known.
    pub counting: Option<CountingName>,
    pub left: Option<PitchBody>,
    pub right: Option<PitchBody>,
    /// R_s: greatest less least thickness of the measured teeth, on the measuring circle. There
    /// where both flanks were measured on one circle.
    pub tooth_thickness_variation_um: Option<f64>,
    /// W_k and M_dK from the places of contact of an imported file. There where it has those of
    /// both flanks of all teeth of an external gear, and the number of teeth of the span.
    pub tooth_thickness: Option<ToothThicknessBody>,
    pub runout: Option<RunoutBody>,
    /// About all of them; each part has its own.
    pub warnings: Vec<NoticeBody>,
}

/// Pitch deviations of a flank.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FlankPitch)]
pub struct PitchBody {
    pub flank: SideName,
    /// Of the measuring circle.
    pub diameter_mm: f64,
    /// About the first tooth that was measured.
    pub index_deviation_um: Vec<Option<f64>>,
    /// f_pi, the deviation of the pitch that ends at each flank; `null` where undefined.
    pub single_pitch_deviation_um: Vec<Option<f64>>,
    /// f_p: the single pitch deviation of greatest amount, with its sign.
    pub single_pitch: Option<ExtremeBody>,
    /// R_p: the greatest single pitch deviation less the least.
    pub single_pitch_range_um: Option<f64>,
    /// F_p: total cumulative pitch deviation, the range of the index deviations.
    pub cumulative_pitch_um: Option<f64>,
    /// Pitches of a sector.
    pub k: Option<usize>,
    /// F_pk of ISO 1328-1:2013, Annex D: the greatest range of the index deviations within any k
    /// pitches (k + 1 flanks), at the tooth where the sector ends.
    pub sector_pitch_2013: Option<ExtremeBody>,
    /// F_pSk of ISO 1328-1:2013, Annex D: of the consecutive sectors of k pitches that begin at
    /// tooth 1, the sum of greatest amount, at the tooth where the sector ends. Pitches behind the
    /// last whole sector are left out.
    pub sector_sum_2013: Option<ExtremeBody>,
    /// F_pk of ISO 1328-1:1995: the sum of any k pitches of greatest amount, at the tooth where the
    /// sector ends. Testers print its amount as F_pz/8.
    pub sector_pitch_1995: Option<ExtremeBody>,
    /// f_u: the greatest difference of neighbouring pitches, at the later of the two.
    pub adjacent_pitch_difference: Option<ExtremeBody>,
    /// What the single pitches add up to, as they were posted.
    pub closure_um: Option<f64>,
    /// Teeth that were not measured.
    pub missing: usize,
    pub class: PitchClassesBody,
    /// What each single pitch deviation was held against.
    #[schema(min_items = 2, max_items = 2)]
    pub single_pitch_limits_um: Option<[f64; 2]>,
    /// Whether every single pitch deviation lies within, as it was measured. There where there are
    /// limits; where teeth were not measured it is false or left out.
    pub single_pitch_within: Option<bool>,
    /// Of the single pitch with the least room. A gear with a pitch at its limit is found to
    /// conform in at most one measurement of twenty, and not to conform more often, the more
    /// pitches lie at theirs (docs/explanation/intervals.md). There where there are limits and an
    /// uncertainty, and no tooth is missing.
    pub single_pitch_conformity: Option<ConformityBody>,
    /// What F_p was held against.
    #[schema(min_items = 2, max_items = 2)]
    pub cumulative_pitch_limits_um: Option<[f64; 2]>,
    /// Whether F_p lies within, likewise.
    pub cumulative_pitch_within: Option<bool>,
    /// Of F_p, likewise.
    pub cumulative_pitch_conformity: Option<ConformityBody>,
    /// What to know about the answer; empty where there is nothing to say.
    pub warnings: Vec<NoticeBody>,
}

/// A value and the tooth, counted from 1, where it was found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ToothExtreme)]
pub struct ExtremeBody {
    /// With its sign.
    pub value_um: f64,
    /// From 1, in the order of counting.
    pub tooth: usize,
}

/// Classes 1 to 11 of ISO 1328-1:2013; left out is what has none, or exceeds even class 11 (then
/// `beyond` names it).
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = PitchClasses)]
pub struct PitchClassesBody {
    /// Of f_p.
    pub single_pitch: Option<u8>,
    /// Of F_p.
    pub cumulative_pitch: Option<u8>,
    /// Names of the two above that exceed even class 11.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beyond: Vec<String>,
}

/// Evaluates the pitches of a request; `own` is the gear of the job and `of` what the iteration
/// that they belong to measured. Where the request has no limits, those that the job requires are
/// taken.
pub fn build(
    text: &[u8],
    own: Option<&Gear>,
    of: Option<&Measurand>,
    required: Option<&RequirementsBody>,
) -> Result<Built, Problem> {
    let mut body: PitchRequestBody = read_json(text)?;
    let posted = body.gear.as_ref().map(|gear| gear.checked("/gear")).transpose().map_err(Problem::invalid)?;
    let Some(gear) = posted.as_ref().or(own) else {
        return Err(Problem::invalid(Faults::one("/gear", "missing")));
    };
    if let Some(of) = of {
        body.belongs_to(of).map_err(Problem::invalid)?;
    }
    let notice = required.and_then(|required| required.fill_pitch(&mut body.pitch_limits, gear));
    let mut answer = body.evaluated(gear).map_err(Problem::invalid)?;
    answer.warnings.extend(notice);
    let result = gathered(writer::whole(&answer).map_err(Problem::not_finite)?);
    Ok(Built { method: "iso_1328_1".to_owned(), result })
}

impl PitchRequestBody {
    /// What is kept with an iteration of one flank has pitches of that flank, or of none.
    fn belongs_to(&self, of: &Measurand) -> Result<(), Faults> {
        let at = if self.left.is_some() { "/left" } else { "/right" };
        let flanks = [(&self.left, Side::Left), (&self.right, Side::Right)];
        let told = flanks.into_iter().filter(|(measured, _)| measured.is_some());
        // all teeth
        refuse_others(of, told.map(|(_, side)| (ToothOf::Unknown, side)), [at; 2])
    }

    /// Pitches and run-out of a gear.
    pub fn evaluated(&self, gear: &Gear) -> Result<PitchEvaluationBody, Faults> {
        let rounding: Rounding = self.tolerances.map_or(Rounding::Rounded, Into::into);
        let mut faults = Faults::default();
        let all = Tolerances::new(gear);
        let (limits, uncertainty) = (self.limits(&all, &mut faults), self.standard_uncertainty_um.unwrap_or_default());
        uncertainty.check("/standard_uncertainty_um", &mut faults);
        let all = all.as_ref().ok();
        let mut evaluated = |measured: &Option<PitchMeasuredBody>, side: Side, at: &str| {
            let (name, measured) = measured.as_ref()?.measured(at, &mut faults)?;
            let settings = PitchSettings { side, diameter: self.diameter_mm, sector: self.sector, rounding };
            let deviations = format!("{at}/{name}");
            match pitch(gear, &measured, &settings) {
                Ok(found) => Some((found, deviations)),
                Err(more) => {
                    // circle and sector are those of both flanks
                    faults.append(Faults::placed(&more, |path| moved(path, &[(name, &deviations)])));
                    None
                }
            }
        };
        let left = evaluated(&self.left, Side::Left, "/left");
        let right = evaluated(&self.right, Side::Right, "/right");
        let mut warnings = Vec::new();
        // pitches from which no run-out follows are still evaluated
        let mut none = |why: &str| {
            warnings.push(NoticeBody::new("no_runout", &format!("no run-out follows from the pitches: {why}")));
        };
        let runout = match (&self.readings_um, &left, &right, self.counting) {
            (Some(readings), ..) => {
                from_readings(gear, &numbers(readings), rounding).map_err(|more| faults.append(more)).ok()
            }
            (None, Some(_), Some(_), None) => {
                none("`counting` decides which flanks bound a space, and is missing");
                None
            }
            (None, Some((left, _)), Some((right, _)), Some(counting)) => {
                let found = from_pitches(gear, left, right, counting, rounding);
                let said = |faults: check::Faults| {
                    let why: Vec<&str> = faults.list().iter().map(|fault| &*fault.message).collect();
                    none(&why.join("; "));
                };
                found.map_err(said).ok()
            }
            _ => None,
        };
        let pair = left.as_ref().zip(right.as_ref()).map(|((left, _), (right, _))| (left, right));
        let tooth_thickness_variation_um = pair.and_then(|(left, right)| thickness_variation(left, right));
        if self.left.is_none() && self.right.is_none() && self.readings_um.is_none() {
            faults.push_missing("/left", "missing; give `left`, `right` or `readings_um`");
        }
        let told = |(mut found, deviations): (Pitch, String)| {
            let asked = self.accept_units != Some(true);
            let implausible = asked.then(|| implausible_pitches(&found.index, gear)).flatten();
            let limits = if implausible.is_some() { PitchLimitsBody::default() } else { limits }.of(found.side);
            if implausible.is_some() {
                (found.single_class, found.cumulative_class) = (None, None);
            }
            let single = limits.single_pitches(&found, all, rounding, uncertainty.single_pitch);
            let cumulative = limits.cumulative_pitch(&found, all, rounding, uncertainty.cumulative_pitch);
            let mut body = PitchBody::new(found, &deviations, single.into(), cumulative.into());
            body.warnings.extend(implausible);
            body
        };
        // it is of both flanks alike
        let of_runout = |found: &Runout| limits.of(Side::Left).runout(found, all, rounding, uncertainty.runout);
        let answer = PitchEvaluationBody {
            counting: self.counting,
            left: left.map(told),
            right: right.map(told),
            tooth_thickness_variation_um,
            tooth_thickness: None,
            runout: runout.map(|found| RunoutBody::new(of_runout(&found).into(), found)),
            warnings,
        };
        faults.into_result(answer)
    }

    /// The limits that hold; a class that gives none on the gear is a fault.
    fn limits(&self, tolerances: &Result<Tolerances, OutOfScope>, faults: &mut Faults) -> PitchLimitsBody {
        let limits = self.pitch_limits.unwrap_or_default();
        let before = faults.count();
        limits.check(LIMITS, faults);
        if let Some(why) = limits.of(Side::Left).class_refused(tolerances).filter(|_| faults.count() == before) {
            faults.push(format!("{LIMITS}/class"), why);
        }
        limits
    }
}

fn numbers(list: &[Option<f64>]) -> Vec<f64> {
    list.iter().map(|x| x.unwrap_or(f64::NAN)).collect()
}

impl PitchMeasuredBody {
    /// What was measured, under its name in the request.
    fn measured(&self, at: &str, faults: &mut Faults) -> Option<(&'static str, PitchMeasured)> {
        match (&self.index_deviation_um, &self.angle_deg, &self.single_pitch_um) {
            (Some(index), None, None) => Some(("index_deviation_um", PitchMeasured::Index(numbers(index)))),
            (None, Some(angles), None) => {
                let angles = numbers(angles).into_iter().map(f64::to_radians).collect();
                Some(("angle_deg", PitchMeasured::Angles(angles)))
            }
            (None, None, Some(single)) => Some(("single_pitch_um", PitchMeasured::Single(numbers(single)))),
            _ => {
                faults.push(at, "give one of `index_deviation_um`, `angle_deg` and `single_pitch_um`");
                None
            }
        }
    }
}

impl From<Extreme> for ExtremeBody {
    fn from(extreme: Extreme) -> Self {
        ExtremeBody { value_um: extreme.value, tooth: extreme.tooth }
    }
}

impl PitchBody {
    /// Of deviations that stand at this place in the request.
    fn new(pitch: Pitch, deviations: &str, single: HeldBody, cumulative: HeldBody) -> Self {
        let mut class = PitchClassesBody::default();
        for (name, found, place) in [
            ("single_pitch", pitch.single_class, &mut class.single_pitch),
            ("cumulative_pitch", pitch.cumulative_class, &mut class.cumulative_pitch),
        ] {
            match found {
                Some(Class::Within(found)) => *place = Some(found),
                Some(Class::Beyond) => class.beyond.push(name.to_owned()),
                None => {}
            }
        }
        PitchBody {
            flank: pitch.side,
            diameter_mm: pitch.diameter,
            index_deviation_um: pitch.index,
            single_pitch_deviation_um: pitch.single,
            single_pitch: pitch.single_pitch.map(ExtremeBody::from),
            single_pitch_range_um: pitch.single_range,
            cumulative_pitch_um: pitch.cumulative,
            k: pitch.sector,
            sector_pitch_2013: pitch.sector_pitch_2013.map(ExtremeBody::from),
            sector_sum_2013: pitch.sector_sum_2013.map(ExtremeBody::from),
            sector_pitch_1995: pitch.sector_pitch_1995.map(ExtremeBody::from),
            adjacent_pitch_difference: pitch.adjacent.map(ExtremeBody::from),
            closure_um: pitch.closure,
            missing: pitch.missing,
            class,
            single_pitch_limits_um: single.limits,
            single_pitch_within: single.within,
            single_pitch_conformity: single.conformity,
            cumulative_pitch_limits_um: cumulative.limits,
            cumulative_pitch_within: cumulative.within,
            cumulative_pitch_conformity: cumulative.conformity,
            warnings: pitch.warnings.iter().map(|warning| NoticeBody::of_pitch(warning, deviations)).collect(),
        }
    }
}
