//! Limits that pitch deviations and the run-out must lie within, and whether they do.
//!
//! Every single pitch must lie within the limits of `f_p`. `F_p` and `F_r` are ranges and never
//! below 0. Of a gear with teeth that were not measured it can be told that it does not conform,
//! never that it does. An uncertainty of measurement is the caller's: nothing in the pitches of one
//! measurement tells it.

use super::{
    limits::{class_refused, within},
    pitch::Pitch,
    runout::Runout,
};
use crate::tolerance::{Characteristic, OutOfScope, Rounding, Tolerances};
use flankfit_estimation::inference::{Conformity, Inferred};
use flankfit_numerics::distribution::Student;

/// Limits of one flank's pitches and of the run-out, µm, ascending.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PitchLimits {
    /// The class of ISO 1328-1 whose tolerances bound what no limits are given for.
    pub class: Option<u8>,
    /// Of each f_pi.
    pub single_pitch: Option<[f64; 2]>,
    /// Of F_p.
    pub cumulative: Option<[f64; 2]>,
    /// Of F_r.
    pub runout: Option<[f64; 2]>,
}

/// A figure against its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// The limits, ascending.
    pub limits: [f64; 2],
    /// Whether it lies within as it was measured; `None` where what was not measured could take it
    /// out.
    pub within: Option<bool>,
    /// Where the uncertainty is known and every tooth was measured.
    pub conformity: Option<Conformity>,
}

impl PitchLimits {
    /// The message of a class that gives no limits.
    pub fn class_refused(&self, tolerances: &Result<Tolerances, OutOfScope>) -> Option<String> {
        class_refused(self.class, tolerances)
    }

    /// Single pitches against their limits, with the standard uncertainty of one; the decision is
    /// that on the pitch with the least room.
    pub fn single_pitches(
        &self,
        pitch: &Pitch,
        tolerances: Option<&Tolerances>,
        rounding: Rounding,
        uncertainty: Option<f64>,
    ) -> Option<Held> {
        let tolerance = || self.of_class(Characteristic::SinglePitch, tolerances?, rounding);
        let limits = self.single_pitch.or_else(|| tolerance().map(|tolerance| [-tolerance, tolerance]))?;
        let room = |value: &f64| (value - limits[0]).min(limits[1] - value);
        let worst = pitch.single.iter().flatten().copied().min_by(|a, b| room(a).total_cmp(&room(b)))?;
        let conformity = uncertainty.map(|error| about(worst, error).conformity(limits));
        Some(Held::new(limits, within(worst, Some(limits)) == Some(true), pitch.complete, conformity))
    }

    /// F_p against its limits, with its standard uncertainty.
    pub fn cumulative_pitch(
        &self,
        pitch: &Pitch,
        tolerances: Option<&Tolerances>,
        rounding: Rounding,
        uncertainty: Option<f64>,
    ) -> Option<Held> {
        let tolerance = || self.of_class(Characteristic::CumulativePitch, tolerances?, rounding);
        let limits = self.cumulative.or_else(|| tolerance().map(|tolerance| [0.0, tolerance]))?;
        Some(range(pitch.cumulative?, limits, pitch.complete, uncertainty))
    }

    /// F_r against its limits, with its standard uncertainty.
    pub fn runout(
        &self,
        runout: &Runout,
        tolerances: Option<&Tolerances>,
        rounding: Rounding,
        uncertainty: Option<f64>,
    ) -> Option<Held> {
        let tolerance = || self.of_class(Characteristic::Runout, tolerances?, rounding);
        let limits = self.runout.or_else(|| tolerance().map(|tolerance| [0.0, tolerance]))?;
        Some(range(runout.runout, limits, runout.missing == 0, uncertainty))
    }

    fn of_class(&self, characteristic: Characteristic, tolerances: &Tolerances, rounding: Rounding) -> Option<f64> {
        tolerances.tolerance(characteristic, self.class?, rounding)
    }
}

impl Held {
    fn new(limits: [f64; 2], lies_within: bool, complete: bool, conformity: Option<Conformity>) -> Self {
        Held {
            limits,
            within: (complete || !lies_within).then_some(lies_within),
            conformity: conformity.filter(|_| complete),
        }
    }
}

/// Of a figure that is never below 0 and that more teeth can only raise.
fn range(value: f64, limits: [f64; 2], complete: bool, uncertainty: Option<f64>) -> Held {
    let [low, high] = limits;
    // no true value lies below 0: that much of the error's distribution is none of a limit's
    let told = [if low <= 0.0 { f64::NEG_INFINITY } else { low }, high];
    let conformity = uncertainty.map(|error| Conformity { limits, ..about(value, error).conformity(told) });
    let beyond = value > high;
    match complete {
        true => Held::new(limits, low <= value && !beyond, true, conformity),
        false => Held::new(limits, !beyond, false, None),
    }
}

fn about(value: f64, std_error: f64) -> Inferred {
    Inferred { value, std_error, bias_bound: 0.0, student: Student::NORMAL }
}
