//! Pitch deviations of both flanks, and run-out.

use std::ops::Deref;

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::{
    api::{
        built::Built,
        faults::{Faults, moved},
        gears::{
            gear::GearBody,
            of_iteration::{ToothOf, refuse_others},
            plausibility::implausible_pitches,
            requirements::RequirementsBody,
        },
        json::{gather::gathered, value::read_json, writer},
        problem::Problem,
        warning::WarningBody,
    },
    jobs::Measurand,
};
use flankfit_engine::{
    formats::klingelnberg::Thickness,
    gear::{
        Gear, Side,
        evaluation::{
            pitch::{Pitch, PitchClasses, PitchMeasured, PitchSettings, pitch, thickness_variation},
            pitch_limits::{PitchLimits, PitchUncertainty},
            runout::{Counting, Runout, from_pitches, from_readings},
        },
        tolerance::{OutOfScope, Rounding, Tolerances},
    },
    numerics::check,
};

/// Pointer of the limits in a request.
const LIMITS: &str = "/pitch_limits";

/// Pitches of one flank or of both, readings of a run-out probe, or all of them. Teeth are in the
/// order of counting; `null` where a tooth was not measured.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = PitchRequest)]
pub struct PitchRequestBody {
    /// Optional if the pitches belong to a job that has it.
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
    /// Direction in which teeth are counted. It decides which flanks bound a space: without it no
    /// run-out follows from pitches.
    pub counting: Option<Counting>,
    /// Which tolerances decide the class. Default `rounded`.
    pub tolerances: Option<Rounding>,
    /// Limits of the figures. By default those of the job's `requirements`.
    pub pitch_limits: Option<PitchLimits>,
    /// Standard uncertainties of the figures, for conformity by ISO 14253-1.
    pub standard_uncertainty_um: Option<PitchUncertainty>,
    /// Confirms that the deviations are in µm although they are far below or above those of any
    /// gear. Otherwise there is a warning `implausible_unit`, and the flank has no class and is not
    /// compared with limits. Default false.
    pub accept_units: Option<bool>,
}

/// Positions of the flanks of all teeth, in one of three forms.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = PitchMeasured)]
pub struct PitchMeasuredBody {
    /// Deviation of each flank from its nominal position along the measuring circle, positive in
    /// the direction in which teeth are counted.
    pub index_deviation_um: Option<Vec<Option<f64>>>,
    /// Angle of each flank from any origin, in the direction in which teeth are counted (ascending
    /// except for full turns).
    pub angle_deg: Option<Vec<Option<f64>>>,
    /// Deviation of the pitch that ends at each flank.
    pub single_pitch_um: Option<Vec<Option<f64>>>,
}

/// Pitch deviations and run-out.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = PitchEvaluation)]
pub struct PitchEvaluationBody {
    /// Direction in which teeth are counted; absent if it is not known.
    pub counting: Option<Counting>,
    pub left: Option<PitchBody>,
    pub right: Option<PitchBody>,
    /// R_s: greatest minus least thickness of the measured teeth, on the measuring circle. Present
    /// if both flanks were measured on one circle.
    pub tooth_thickness_variation_um: Option<f64>,
    /// W_k and M_dK from the points of contact of an imported file. Present if it has those of both
    /// flanks of all teeth of an external gear, and the number of teeth of the span.
    pub tooth_thickness: Option<Thickness>,
    pub runout: Option<RunoutBody>,
    /// Warnings about all of them; each part has its own.
    pub warnings: Vec<WarningBody>,
}

/// Pitch deviations of a flank.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FlankPitch)]
pub struct PitchBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub result: Pitch,
    /// Warnings.
    pub warnings: Vec<WarningBody>,
}

impl Deref for PitchBody {
    type Target = Pitch;

    fn deref(&self) -> &Pitch {
        &self.result
    }
}

/// Run-out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = GearRunout)]
pub struct RunoutBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub result: Runout,
    /// Warnings.
    pub warnings: Vec<WarningBody>,
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
        return Err(Problem::invalid(Faults::one("/gear", "required")));
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
    /// Checks that a record of an iteration of one flank has pitches of that flank, or of none.
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
        faults.append(Faults::of_engine("/standard_uncertainty_um", &uncertainty.check()));
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
            warnings.push(WarningBody::new("no_runout", format!("no run-out follows from the pitches: {why}")));
        };
        let runout = match (&self.readings_um, &left, &right, self.counting) {
            (Some(readings), ..) => {
                from_readings(gear, &numbers(readings), rounding).map_err(|more| faults.append(more)).ok()
            }
            (None, Some(_), Some(_), None) => {
                none("`counting`, which decides which flanks bound a space, is missing");
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
            let implausible = asked.then(|| implausible_pitches(&found.index_deviation_um, gear)).flatten();
            let limits = if implausible.is_some() { PitchLimits::default() } else { limits };
            if implausible.is_some() {
                found.class = PitchClasses::default();
            }
            let single = limits.single_pitches(&found, all, rounding, uncertainty.single_pitch);
            let cumulative = limits.cumulative_pitch(&found, all, rounding, uncertainty.cumulative_pitch);
            found.hold(single, cumulative);
            let warnings = found.warnings.iter().map(|warning| WarningBody::of_pitch(warning, &deviations));
            PitchBody { warnings: warnings.chain(implausible).collect(), result: found }
        };
        let of_runout = |found: Runout| {
            let held = limits.runout(&found, all, rounding, uncertainty.runout);
            let warnings = found.warnings.iter().map(WarningBody::from).collect();
            RunoutBody { result: Runout { held, ..found }, warnings }
        };
        let answer = PitchEvaluationBody {
            counting: self.counting,
            left: left.map(told),
            right: right.map(told),
            tooth_thickness_variation_um,
            tooth_thickness: None,
            runout: runout.map(of_runout),
            warnings,
        };
        faults.into_result(answer)
    }

    /// The limits that hold; a class that gives none on the gear is a fault.
    fn limits(&self, tolerances: &Result<Tolerances, OutOfScope>, faults: &mut Faults) -> PitchLimits {
        let limits = self.pitch_limits.unwrap_or_default();
        let found = limits.check();
        if let Some(why) = limits.class_refused(tolerances).filter(|_| found.is_empty()) {
            faults.push(format!("{LIMITS}/class"), why);
        }
        faults.append(Faults::of_engine(LIMITS, &found));
        limits
    }
}

fn numbers(list: &[Option<f64>]) -> Vec<f64> {
    list.iter().map(|x| x.unwrap_or(f64::NAN)).collect()
}

impl PitchMeasuredBody {
    /// Returns the measurement under its name in the request.
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
