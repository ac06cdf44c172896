//! Limits that figures of a flank must lie within, and what is inferred of a figure.

use super::fault::{ToleranceField, ToleranceReason};
use crate::{
    estimation::{
        inference::{Conformity, Inferred},
        result::IntervalKind,
    },
    fault::Faults,
    gear::{
        Kind,
        tolerance::{COARSEST, Characteristic, FINEST, OutOfScope, Rounding, Tolerances},
    },
};

/// Limits of the figures, µm, in the sign that they are answered in; ascending.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToleranceLimits {
    /// The class of ISO 1328-1 whose tolerances bound the slopes that no limits are given for.
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
}

/// A figure's confidence interval, and whether it conforms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inference {
    /// Confidence interval at the level asked for.
    pub interval: [f64; 2],
    /// What it rests on.
    pub kind: IntervalKind,
    /// Against its limits, where there are any.
    pub conformity: Option<Conformity>,
}

impl Inference {
    /// Of an unbiased figure.
    pub(super) fn new(about: &Inferred, level: f64, limits: Option<[f64; 2]>) -> Self {
        Inference {
            interval: about.interval(level),
            kind: IntervalKind::Student,
            conformity: limits.map(|limits| about.conformity(limits)),
        }
    }
}

impl ToleranceLimits {
    /// What is wrong with the limits; `helix` says whether slopes of helices are asked for.
    pub(super) fn check(
        &self,
        tolerances: &Result<Tolerances, OutOfScope>,
        helix: bool,
    ) -> Faults<ToleranceField, ToleranceReason> {
        let mut faults = Faults::default();
        let told = [
            (ToleranceField::ProfileSlope, self.profile_slope),
            (ToleranceField::HelixSlope, self.helix_slope),
            (ToleranceField::ProfileCrowning, self.profile_crowning),
            (ToleranceField::HelixCrowning, self.helix_crowning),
            (ToleranceField::Twist, self.twist),
        ];
        for (field, limits) in told {
            if let Some([low, high]) = limits.filter(|[low, high]| !(low < high)) {
                faults.push(field, ToleranceReason::NotAscending([low, high]));
            }
        }
        match (self.class, tolerances) {
            (None, _) => {}
            (Some(class), _) if !(FINEST..=COARSEST).contains(&class) => {
                faults.push(ToleranceField::Class, ToleranceReason::NoClass(class));
            }
            (Some(_), Err(out)) => faults.push(ToleranceField::Class, ToleranceReason::OutOfScope(out.clone())),
            (Some(class), Ok(tolerances)) => {
                let open = helix && self.helix_slope.is_none();
                if open && tolerances.unrounded(Characteristic::HelixSlope, class).is_none() {
                    faults.push(ToleranceField::Class, ToleranceReason::NoFaceWidth);
                }
            }
        }
        faults
    }

    /// Limits of a slope that were told.
    pub(super) fn slope(&self, kind: Kind) -> Option<[f64; 2]> {
        match kind {
            Kind::Profile => self.profile_slope,
            Kind::Helix => self.helix_slope,
        }
    }

    /// Limits of a slope by the class.
    pub(super) fn slope_of_class(&self, kind: Kind, tolerances: &Tolerances, rounding: Rounding) -> Option<[f64; 2]> {
        let characteristic = match kind {
            Kind::Profile => Characteristic::ProfileSlope,
            Kind::Helix => Characteristic::HelixSlope,
        };
        let tolerance = match rounding {
            Rounding::Rounded => tolerances.rounded(characteristic, self.class?),
            Rounding::Unrounded => tolerances.unrounded(characteristic, self.class?),
        };
        tolerance.map(|tolerance| [-tolerance, tolerance])
    }

    /// Limits of a crowning.
    pub(super) fn crowning(&self, kind: Kind) -> Option<[f64; 2]> {
        match kind {
            Kind::Profile => self.profile_crowning,
            Kind::Helix => self.helix_crowning,
        }
    }
}
