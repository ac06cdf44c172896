//! A trace that is to be evaluated.

use super::{
    limits::{Inference, TraceLimits},
    noise::EstimatedVariance,
    settings::{Settings, Window},
    values::{Assessable, Values},
    warning::{TraceWarning, Warning},
};
use crate::{Gear, Trace, tolerance::Tolerances, trace::Direction};

/// A trace about its design, ready to be evaluated.
pub(super) struct Subject<'a> {
    pub gear: &'a Gear,
    pub trace: &'a Trace,
    pub design: Option<&'a [f64]>,
    pub settings: &'a Settings,
    pub window: &'a Window,
    /// Number of the trace, from 0.
    pub number: usize,
}

impl Subject<'_> {
    /// Limits of the trace, by the tolerances of a class where they cover it.
    /// Where the range is not measured to its ends nothing conforms, and over a hole a form may be
    /// anything.
    pub(super) fn limits(&self, assessable: Assessable, tolerances: Option<&Tolerances>) -> TraceLimits {
        let settings = self.settings;
        let limits = settings.limits.of(self.trace.side).of_trace(self.trace.kind, tolerances, settings.rounding);
        match assessable {
            Assessable::Everything => limits,
            Assessable::Slope => TraceLimits { form: None, total: None, ..limits },
            Assessable::Figures | Assessable::Nothing => TraceLimits::default(),
        }
    }

    /// Returns what is inferred of slope and crowning.
    pub(super) fn inferences(&self, values: &Values) -> [Option<Inference>; 2] {
        let inference = |value: f64, std_error: Option<f64>| {
            let variance =
                EstimatedVariance { value: std_error?.powi(2), freedom: values.freedom?, doubts: values.doubts };
            Some(Inference::new(&variance.about(value), self.settings.level))
        };
        [
            inference(values.slope_um, values.slope_std_error_um),
            inference(values.crowning_um, values.crowning_std_error_um),
        ]
    }

    /// Factor that makes a posted deviation one of material, transverse.
    pub(super) fn to_material(&self) -> f64 {
        let settings = self.settings;
        settings.given.to_material(self.trace.kind, self.trace.side)
            * match settings.direction {
                Direction::Transverse => 1.0,
                Direction::Normal => 1.0 / self.gear.base_helix_angle().cos(),
            }
    }

    /// A warning about this trace.
    pub(super) fn warning(&self, warning: TraceWarning) -> Warning {
        Warning::Trace { trace: self.number, warning }
    }

    pub(super) fn warn(&self, warnings: &mut Vec<Warning>, warning: TraceWarning) {
        warnings.push(self.warning(warning));
    }
}
