//! Limits that pitch deviations and the run-out must lie within, and whether they do.
//!
//! Every single pitch must lie within the limits of `f_p`. `F_p` and `F_r` are ranges and never
//! below 0. A gear with teeth that were not measured can be found not to conform,
//! never that it does. An uncertainty of measurement is the caller's: nothing in the pitches of one
//! measurement shows it.

use super::{
    limits::{ascending, class_refused, no_class, within},
    pitch::Pitch,
    runout::Runout,
};
use crate::{
    Side,
    tolerance::{Characteristic, OutOfScope, Rounding, Tolerances},
};
use flankfit_estimation::inference::{Conformity, Inferred};
use flankfit_numerics::check::Faults;

/// Limits of pitch deviations and the run-out, `[low, high]` in µm. Each figure that has limits is
/// returned with `within`, and with its conformity if `standard_uncertainty_um` gives its
/// uncertainty.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(deny_unknown_fields),
    schema(example = json!({
        "class": 6, "runout_um": [0, 15], "left": {"single_pitch_um": [-5, 5]}
    }))
)]
pub struct PitchLimits {
    /// Class 1 to 11 of ISO 1328-1:2013: its tolerances are the limits of figures without limits
    /// here.
    #[cfg_attr(feature = "contract", schema(minimum = 1, maximum = 11))]
    pub class: Option<u8>,
    /// Limits of every single pitch deviation f_pi of both flanks.
    #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
    pub single_pitch_um: Option<[f64; 2]>,
    /// Limits of F_p of both flanks.
    #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
    pub cumulative_pitch_um: Option<[f64; 2]>,
    /// Limits of F_r.
    #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
    pub runout_um: Option<[f64; 2]>,
    /// Limits of left flanks, which replace those for both.
    pub left: Option<FlankPitchLimits>,
    /// Limits of right flanks, likewise.
    pub right: Option<FlankPitchLimits>,
}

/// Limits of the pitch deviations of one flank, `[low, high]` in µm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(deny_unknown_fields)
)]
pub struct FlankPitchLimits {
    /// Limits of every single pitch deviation f_pi.
    #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
    pub single_pitch_um: Option<[f64; 2]>,
    /// Limits of F_p.
    #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
    pub cumulative_pitch_um: Option<[f64; 2]>,
}

/// Standard uncertainty of the measurement (one standard deviation, not an expanded one), which the
/// pitches themselves do not determine. A figure without one has no decision.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(deny_unknown_fields)
)]
pub struct PitchUncertainty {
    /// Uncertainty of a single pitch deviation.
    #[cfg_attr(feature = "contract", schema(exclusive_minimum = 0, maximum = 1e6))]
    pub single_pitch: Option<f64>,
    /// Uncertainty of F_p.
    #[cfg_attr(feature = "contract", schema(exclusive_minimum = 0, maximum = 1e6))]
    pub cumulative_pitch: Option<f64>,
    /// Uncertainty of F_r.
    #[cfg_attr(feature = "contract", schema(exclusive_minimum = 0, maximum = 1e6))]
    pub runout: Option<f64>,
}

/// Greatest standard uncertainty, µm.
const MOST_UNCERTAINTY: f64 = 1e6;

impl PitchUncertainty {
    /// Refuses what is no uncertainty.
    pub fn check(&self) -> Faults {
        let named =
            [("single_pitch", self.single_pitch), ("cumulative_pitch", self.cumulative_pitch), ("runout", self.runout)];
        let mut faults = Faults::default();
        for (name, value) in named {
            if let Some(value) = value.filter(|value| !(*value > 0.0 && *value <= MOST_UNCERTAINTY)) {
                faults.push(name, format_args!("{value} is not above 0 and at most {MOST_UNCERTAINTY}"));
            }
        }
        faults
    }
}

/// Comparison of a figure with its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Held {
    /// The limits, ascending.
    pub limits_um: [f64; 2],
    /// True if the figure lies within its limits, as measured. If readings are missing it is false
    /// or absent.
    pub within: Option<bool>,
    /// Conformity with the limits, if there is an uncertainty and nothing is missing.
    pub conformity: Option<Conformity>,
}

impl PitchLimits {
    /// Returns the limits of the pitches of a flank.
    fn of(&self, side: Side) -> FlankPitchLimits {
        let own = match side {
            Side::Left => self.left,
            Side::Right => self.right,
        };
        let own = own.unwrap_or_default();
        FlankPitchLimits {
            single_pitch_um: own.single_pitch_um.or(self.single_pitch_um),
            cumulative_pitch_um: own.cumulative_pitch_um.or(self.cumulative_pitch_um),
        }
    }

    /// Refuses limits that are impossible on any gear.
    pub fn check(&self) -> Faults {
        let mut faults = Faults::default();
        if let Some(message) = self.class.and_then(no_class) {
            faults.push("class", message);
        }
        let both =
            FlankPitchLimits { single_pitch_um: self.single_pitch_um, cumulative_pitch_um: self.cumulative_pitch_um };
        faults.append(both.check());
        faults.append(ascending(&[("runout_um", self.runout_um)]));
        for (name, own) in [("left", self.left), ("right", self.right)] {
            faults.append(own.map_or_else(Faults::default, |own| own.check().within(name)));
        }
        faults
    }

    /// The message of a class that gives no limits.
    pub fn class_refused(&self, tolerances: &Result<Tolerances, OutOfScope>) -> Option<String> {
        class_refused(self.class, tolerances)
    }

    /// Single pitches against their limits, with the standard uncertainty of one; the decision is
    /// that on the pitch nearest to its limits.
    pub fn single_pitches(
        &self,
        pitch: &Pitch,
        tolerances: Option<&Tolerances>,
        rounding: Rounding,
        uncertainty: Option<f64>,
    ) -> Option<Held> {
        let tolerance = || self.of_class(Characteristic::SinglePitch, tolerances?, rounding);
        let limits =
            self.of(pitch.flank).single_pitch_um.or_else(|| tolerance().map(|tolerance| [-tolerance, tolerance]))?;
        let room = |value: &f64| (value - limits[0]).min(limits[1] - value);
        let worst =
            pitch.single_pitch_deviation_um.iter().flatten().copied().min_by(|a, b| room(a).total_cmp(&room(b)))?;
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
        let limits =
            self.of(pitch.flank).cumulative_pitch_um.or_else(|| tolerance().map(|tolerance| [0.0, tolerance]))?;
        Some(range(pitch.cumulative_pitch_um?, limits, pitch.complete, uncertainty))
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
        let limits = self.runout_um.or_else(|| tolerance().map(|tolerance| [0.0, tolerance]))?;
        Some(range(runout.runout_um, limits, runout.missing == 0, uncertainty))
    }

    fn of_class(&self, characteristic: Characteristic, tolerances: &Tolerances, rounding: Rounding) -> Option<f64> {
        tolerances.tolerance(characteristic, self.class?, rounding)
    }
}

impl FlankPitchLimits {
    fn check(&self) -> Faults {
        ascending(&[("single_pitch_um", self.single_pitch_um), ("cumulative_pitch_um", self.cumulative_pitch_um)])
    }
}

impl Held {
    fn new(limits: [f64; 2], lies_within: bool, complete: bool, conformity: Option<Conformity>) -> Self {
        Held {
            limits_um: limits,
            within: (complete || !lies_within).then_some(lies_within),
            conformity: conformity.filter(|_| complete),
        }
    }
}

/// Decides on a figure that is never below 0 and that more teeth can only raise.
fn range(value: f64, limits: [f64; 2], complete: bool, uncertainty: Option<f64>) -> Held {
    let [low, high] = limits;
    // no true value lies below 0: that much of the error's distribution is none of a limit's
    let open_limits = [if low <= 0.0 { f64::NEG_INFINITY } else { low }, high];
    let conformity = uncertainty.map(|error| Conformity { limits, ..about(value, error).conformity(open_limits) });
    let beyond = value > high;
    match complete {
        true => Held::new(limits, low <= value && !beyond, true, conformity),
        false => Held::new(limits, !beyond, false, None),
    }
}

fn about(value: f64, std_error: f64) -> Inferred {
    Inferred { value, std_error, ..Inferred::default() }
}
