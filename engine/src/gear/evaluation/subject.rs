//! A trace that is to be evaluated, and the figures that it can have.

use super::{
    fault::TraceField,
    notice::Notice,
    settings::{Settings, Window},
};
use crate::gear::{Gear, Trace};

/// Fewest defined samples of the evaluation range.
pub const FEWEST_SAMPLES: usize = 5;
/// Samples this near to the end of a range belong to it, mm: positions are rounded numbers.
pub const EDGE: f64 = 1e-6;

/// The figures of a trace, µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Values {
    /// f_H, in the sign asked for.
    pub slope: f64,
    /// Standard error of the slope, from the noise of the samples and from what gaps between them
    /// may hide; none where they are too few to tell it.
    pub slope_std_error: Option<f64>,
    /// f_f.
    pub form: f64,
    /// F.
    pub total: f64,
    /// C.
    pub crowning: f64,
    /// Standard error of the crowning; none where the samples are too few to tell it.
    pub crowning_std_error: Option<f64>,
    /// By how much plus material outside the evaluation range raised the form and the total
    /// deviation; 0 where the rule leaves it out.
    pub form_plus_material: f64,
    /// The same for the total deviation.
    pub total_plus_material: f64,
}

/// Which figures of a trace may have a class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Assessable {
    /// No class, and no figure either.
    Nothing,
    /// No class, though there are figures: the samples do not reach both ends of the range.
    Figures,
    /// The slope only, where two standard errors up and down have one class: over a hole a form may
    /// be anything.
    Slope,
    /// All classes and figures.
    Everything,
}

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
    /// A notice about the deviations of the trace.
    pub(super) fn notice(&self, code: &'static str, message: String) -> Notice {
        Notice { code, field: Some(TraceField::Deviations { trace: self.number }), message }
    }

    pub(super) fn note(&self, notices: &mut Vec<Notice>, code: &'static str, message: String) {
        notices.push(self.notice(code, message));
    }
}
