//! Limits that figures of a flank must lie within, and what is inferred of a figure.

use crate::{
    Gear, Kind, Side,
    tolerance::{COARSEST, Characteristic, FINEST, OutOfScope, Rounding, Tolerances},
};
use flankfit_estimation::{
    inference::{Conformity, Inferred},
    result::IntervalKind,
};
use flankfit_numerics::{check::Faults, words::Shown};

/// Limits of the figures, µm, in the sign that they are answered in; ascending.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToleranceLimits {
    /// The class of ISO 1328-1 whose tolerances bound slopes, forms and totals that no limits are
    /// given for.
    pub class: Option<u8>,
    /// Of f_Hα.
    pub profile_slope: Option<[f64; 2]>,
    /// Of f_Hβ.
    pub helix_slope: Option<[f64; 2]>,
    /// Of C_α.
    pub profile_crowning: Option<[f64; 2]>,
    /// Of C_β.
    pub helix_crowning: Option<[f64; 2]>,
    /// Of the twist of a surface.
    pub twist: Option<[f64; 2]>,
    /// Of f_fα.
    pub profile_form: Option<[f64; 2]>,
    /// Of f_fβ.
    pub helix_form: Option<[f64; 2]>,
    /// Of F_α.
    pub profile_total: Option<[f64; 2]>,
    /// Of F_β.
    pub helix_total: Option<[f64; 2]>,
}

/// Limits of the figures of left and right flanks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SidedLimits {
    /// Of left flanks.
    pub left: ToleranceLimits,
    /// Of right flanks.
    pub right: ToleranceLimits,
}

impl From<ToleranceLimits> for SidedLimits {
    /// The same of both flanks.
    fn from(limits: ToleranceLimits) -> Self {
        SidedLimits { left: limits, right: limits }
    }
}

impl SidedLimits {
    /// Those of a flank.
    pub fn of(&self, side: Side) -> &ToleranceLimits {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
        }
    }

    /// What is wrong with them, each fault once.
    pub(super) fn check(&self, tolerances: &Result<Tolerances, OutOfScope>, helix: bool) -> Faults {
        let left = self.left.check(tolerances, helix);
        if left.is_empty() { self.right.check(tolerances, helix) } else { left }
    }
}

/// The limits that a trace was held against, µm; `None` where there are none, or where the trace
/// does not tell enough to be held against them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TraceLimits {
    /// Of f_H.
    pub slope: Option<[f64; 2]>,
    /// Of f_f.
    pub form: Option<[f64; 2]>,
    /// Of F.
    pub total: Option<[f64; 2]>,
    /// Of C.
    pub crowning: Option<[f64; 2]>,
}

/// Whether a figure lies within its limits, as it was estimated.
pub fn within(value: f64, limits: Option<[f64; 2]>) -> Option<bool> {
    limits.map(|[low, high]| low <= value && value <= high)
}

/// A figure's confidence interval, and whether it conforms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inference {
    /// Confidence interval at the level asked for.
    pub interval: [f64; 2],
    /// What it rests on.
    pub kind: IntervalKind,
    /// The estimate that interval and conformity are made of.
    pub about: Inferred,
    /// Against its limits, where there are any.
    pub conformity: Option<Conformity>,
}

impl Inference {
    /// Of an unbiased figure.
    pub(super) fn new(about: &Inferred, level: f64, limits: Option<[f64; 2]>) -> Self {
        Inference {
            interval: about.interval(level),
            kind: IntervalKind::Student,
            about: *about,
            conformity: limits.map(|limits| about.conformity(limits)),
        }
    }
}

/// The message of limits that do not ascend, µm, where they do not.
pub fn not_ascending_limits([low, high]: [f64; 2]) -> Option<String> {
    let ascend = low < high;
    let [low, high] = [low, high].map(Shown);
    (!ascend).then(|| format!("{low} to {high} µm leave nothing between them; write the lower limit first"))
}

/// The message of a class that there is not, where there is none.
pub fn no_class(class: u8) -> Option<String> {
    let there = (FINEST..=COARSEST).contains(&class);
    (!there).then(|| format!("{class} is not one of {FINEST} to {COARSEST}"))
}

/// The message of a class that gives no tolerances, where one is asked for.
pub(super) fn class_refused(class: Option<u8>, tolerances: &Result<Tolerances, OutOfScope>) -> Option<String> {
    match (no_class(class?), tolerances) {
        (Some(message), _) => Some(message),
        (_, Err(out)) => Some(format!("the class gives no limits: {out}")),
        (_, Ok(_)) => None,
    }
}

impl ToleranceLimits {
    /// What is wrong with the limits; `helix` says whether slopes of helices are asked for.
    pub(super) fn check(&self, tolerances: &Result<Tolerances, OutOfScope>, helix: bool) -> Faults {
        let mut faults = Faults::default();
        let told = [
            ("profile_slope_um", self.profile_slope),
            ("helix_slope_um", self.helix_slope),
            ("profile_crowning_um", self.profile_crowning),
            ("helix_crowning_um", self.helix_crowning),
            ("twist_um", self.twist),
            ("profile_form_um", self.profile_form),
            ("helix_form_um", self.helix_form),
            ("profile_total_um", self.profile_total),
            ("helix_total_um", self.helix_total),
        ];
        for (path, limits) in told {
            if let Some(message) = limits.and_then(not_ascending_limits) {
                faults.push(path, message);
            }
        }
        if let Some(message) = self.class_without_limits(tolerances, helix) {
            faults.push("class", message);
        }
        faults
    }

    fn class_without_limits(&self, tolerances: &Result<Tolerances, OutOfScope>, helix: bool) -> Option<String> {
        let no_face_width = || {
            let open = helix && self.helix_slope.is_none();
            let slope = tolerances.as_ref().ok()?.unrounded(Characteristic::HelixSlope, self.class?);
            let message =
                "the class gives no limits of helix slopes without the face width of the gear; give it, or the limits";
            (open && slope.is_none()).then(|| message.to_owned())
        };
        class_refused(self.class, tolerances).or_else(no_face_width)
    }

    /// The message of a class that gives no limits on this gear, where one is asked for.
    pub fn class_refused(&self, gear: &Gear, helix: bool) -> Option<String> {
        self.class_without_limits(&Tolerances::new(gear), helix)
    }

    /// Returns the limits of a slope over a share of the length that it refers to: those given,
    /// else those of the class. ISO 1328-1 has slopes over the whole length (profiles: the
    /// evaluation length, helices: the face width), so that a part of it has its share of the
    /// limits, and a greater length no more than the whole limits. `along` converts the tolerances
    /// of the class, which are transverse, to the direction of the figures.
    pub(super) fn slope_over(
        &self,
        kind: Kind,
        share: f64,
        along: f64,
        tolerances: Option<&Tolerances>,
        rounding: Rounding,
    ) -> Option<[f64; 2]> {
        let of_class = || Some(self.slope_of_class(kind, tolerances?, rounding)?.map(|end| along * end));
        let whole = self.slope(kind).or_else(of_class)?;
        let share = share.min(1.0);
        Some(whole.map(|end| end * share))
    }

    /// Limits of a slope that were told.
    fn slope(&self, kind: Kind) -> Option<[f64; 2]> {
        match kind {
            Kind::Profile => self.profile_slope,
            Kind::Helix => self.helix_slope,
        }
    }

    /// Limits of a slope by the class.
    fn slope_of_class(&self, kind: Kind, tolerances: &Tolerances, rounding: Rounding) -> Option<[f64; 2]> {
        let characteristic = match kind {
            Kind::Profile => Characteristic::ProfileSlope,
            Kind::Helix => Characteristic::HelixSlope,
        };
        self.of_class(characteristic, tolerances, rounding).map(|tolerance| [-tolerance, tolerance])
    }

    fn of_class(&self, characteristic: Characteristic, tolerances: &Tolerances, rounding: Rounding) -> Option<f64> {
        tolerances.tolerance(characteristic, self.class?, rounding)
    }

    /// Limits of a trace: as they were told, else those of the class.
    pub(super) fn of_trace(&self, kind: Kind, tolerances: Option<&Tolerances>, rounding: Rounding) -> TraceLimits {
        let [form, total] = match kind {
            Kind::Profile => [self.profile_form, self.profile_total],
            Kind::Helix => [self.helix_form, self.helix_total],
        };
        let [form_of, total_of] = match kind {
            Kind::Profile => [Characteristic::ProfileForm, Characteristic::ProfileTotal],
            Kind::Helix => [Characteristic::HelixForm, Characteristic::HelixTotal],
        };
        // neither is ever below 0
        let of_class = |of| self.of_class(of, tolerances?, rounding).map(|tolerance| [0.0, tolerance]);
        TraceLimits {
            slope: self.slope_over(kind, 1.0, 1.0, tolerances, rounding),
            form: form.or_else(|| of_class(form_of)),
            total: total.or_else(|| of_class(total_of)),
            crowning: self.crowning(kind),
        }
    }

    /// Limits of a crowning.
    pub(super) fn crowning(&self, kind: Kind) -> Option<[f64; 2]> {
        match kind {
            Kind::Profile => self.profile_crowning,
            Kind::Helix => self.helix_crowning,
        }
    }
}
