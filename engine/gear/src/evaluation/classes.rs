//! Classes of the figures of a trace, and whether a hole leaves them open.

use super::{
    values::{Assessable, Values},
    warning::TraceWarning,
};
use crate::{
    Kind,
    tolerance::{Characteristic, Class, Rounding, Tolerances},
};

/// Over a hole a slope has the class that it has by so many standard errors more and less.
pub(crate) const SURE: f64 = 2.0;

/// Classes of slope, form and total deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Classes {
    /// `None` where a hole in the trace leaves it open.
    pub slope: Option<Class>,
    /// `None` over a hole in the trace.
    pub form: Option<Class>,
    /// `None` where a hole in the trace leaves it open.
    pub total: Option<Class>,
}

/// Figures that may have classes.
pub(super) struct Classified<'a> {
    pub tolerances: &'a Tolerances,
    pub kind: Kind,
    pub rounding: Rounding,
    pub values: &'a Values,
}

/// The classes of a trace, and why its slope has none though it might.
pub(super) struct Found {
    pub classes: Option<Classes>,
    pub open: Option<TraceWarning>,
}

impl Classified<'_> {
    pub(super) fn classes(&self, told: Assessable) -> Found {
        let [slope, form, total] = match self.kind {
            Kind::Profile => [Characteristic::ProfileSlope, Characteristic::ProfileForm, Characteristic::ProfileTotal],
            Kind::Helix => [Characteristic::HelixSlope, Characteristic::HelixForm, Characteristic::HelixTotal],
        };
        let (values, whole) = (self.values, told == Assessable::Everything);
        let (of_slope, open) = match told {
            Assessable::Nothing | Assessable::Figures => return Found { classes: None, open: None },
            Assessable::Everything => (self.class(slope, values.slope), None),
            Assessable::Slope => match self.of_uncertain(slope) {
                Ok(class) => (class, None),
                Err(why) => (None, Some(why)),
            },
        };
        let found = Classes {
            slope: of_slope,
            form: self.class(form, values.form).filter(|_| whole),
            total: self.class(total, values.total).filter(|_| whole),
        };
        let any = found.slope.is_some() || found.form.is_some() || found.total.is_some();
        Found { classes: any.then_some(found), open }
    }

    fn class(&self, characteristic: Characteristic, value: f64) -> Option<Class> {
        self.tolerances.class(characteristic, value, self.rounding)
    }

    /// The class of a slope over a hole, or why it has none.
    fn of_uncertain(&self, slope: Characteristic) -> Result<Option<Class>, TraceWarning> {
        let amount = self.values.slope.abs();
        let Some(error) = self.values.slope_std_error else {
            return Err(TraceWarning::SlopeClassUnknown);
        };
        let by = |errors: f64| self.class(slope, (amount + errors * error).max(0.0));
        let (least, most) = (by(-SURE), by(SURE));
        if least == most {
            return Ok(most);
        }
        Err(TraceWarning::SlopeClassOpen { slope: self.values.slope, std_error: error })
    }
}
