//! A trace that is to be evaluated.

use super::{
    settings::{Settings, Window},
    warning::{TraceWarning, Warning},
};
use crate::gear::{Gear, Trace};

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
    /// A warning about this trace.
    pub(super) fn warning(&self, warning: TraceWarning) -> Warning {
        Warning::Trace { trace: self.number, warning }
    }

    pub(super) fn warn(&self, warnings: &mut Vec<Warning>, warning: TraceWarning) {
        warnings.push(self.warning(warning));
    }
}
