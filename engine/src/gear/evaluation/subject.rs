//! A trace that is to be evaluated.

use super::{
    limits::Inference,
    noise::EstimatedVariance,
    settings::{Settings, Window},
    values::{Assessable, Values},
    warning::{TraceWarning, Warning},
};
use crate::gear::{Gear, Trace, tolerance::Tolerances, trace::Direction};

/// A trace about its design, ready to be evaluated.
pub(super) struct Subject<'a> {
    pub gear: &'a Gear,
    pub trace: &'a Trace,
    pub design: Option<&'a [f64]>,
    pub settings: &'a Settings,
    pub window: &'a Window,
    /// Of the trace, from 0.
    pub number: usize,
}

impl Subject<'_> {
    /// By what deviations as they were given are multiplied: material positive, transverse.
    pub(super) fn scale(&self) -> f64 {
        self.settings.given.to_material(self.trace.kind, self.trace.side)
            * match self.settings.direction {
                Direction::Transverse => 1.0,
                Direction::Normal => 1.0 / self.gear.base_helix_angle().cos(),
            }
    }

    /// Intervals of slope and crowning, and whether they conform; by the tolerances of a class
    /// where they speak about the trace.
    pub(super) fn inferences(
        &self,
        values: &Values,
        assessable: Assessable,
        tolerances: Option<&Tolerances>,
    ) -> [Option<Inference>; 2] {
        let (settings, kind) = (self.settings, self.trace.kind);
        let of_class = || settings.limits.slope_of_class(kind, tolerances?, settings.rounding);
        let inference = |value: f64, std_error: Option<f64>, limits: Option<[f64; 2]>| {
            let variance = EstimatedVariance { value: std_error?.powi(2), freedom: values.freedom? };
            // where the range is not measured to its ends nothing conforms
            let limits = limits.filter(|_| matches!(assessable, Assessable::Slope | Assessable::Everything));
            Some(Inference::new(&variance.about(value), settings.level, limits))
        };
        [
            inference(values.slope, values.slope_std_error, settings.limits.slope(kind).or_else(of_class)),
            inference(values.crowning, values.crowning_std_error, settings.limits.crowning(kind)),
        ]
    }

    /// A warning about this trace.
    pub(super) fn warning(&self, warning: TraceWarning) -> Warning {
        Warning::Trace { trace: self.number, warning }
    }

    pub(super) fn warn(&self, warnings: &mut Vec<Warning>, warning: TraceWarning) {
        warnings.push(self.warning(warning));
    }
}
