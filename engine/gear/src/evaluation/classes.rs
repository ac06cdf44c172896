//! Classes of the figures of a trace, and whether a hole leaves them open.

use super::{
    values::{Assessable, Values},
    warning::TraceWarning,
};
use crate::{
    Kind,
    tolerance::{Characteristic, Class, Rounding, Tolerances, numbered},
};

/// Over a hole a slope has the class that it has by so many standard errors more and less.
pub(crate) const SURE: f64 = 2.0;

/// Classes 1 to 11 of ISO 1328-1:2013. Those coarser than 11 are absent and named by
/// `coarser_than_11`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = TraceClasses)
)]
pub struct Classes {
    /// Class of f_Hα or f_Hβ, 1 to 11.
    pub slope: Option<u8>,
    /// Class of f_fα or f_fβ, 1 to 11; none over a hole in the trace.
    pub form: Option<u8>,
    /// Class of F_α or F_β, 1 to 11; none over a hole in the trace.
    pub total: Option<u8>,
    /// Names of those that exceed even class 11.
    #[cfg_attr(feature = "contract", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub coarser_than_11: Vec<String>,
}

impl Classes {
    /// Returns the coarsest one.
    pub(super) fn coarsest(&self) -> Option<Class> {
        let within = [self.slope, self.form, self.total].into_iter().flatten().max().map(Class::Within);
        if self.coarser_than_11.is_empty() { within } else { Some(Class::Beyond) }
    }
}

/// Figures that may have classes.
pub(super) struct Classified<'a> {
    pub tolerances: &'a Tolerances,
    pub kind: Kind,
    pub rounding: Rounding,
    pub values: &'a Values,
}

/// The classes of a trace, and why its slope has none though it might.
pub(super) struct ClassesFound {
    pub classes: Option<Classes>,
    pub open: Option<TraceWarning>,
}

impl Classified<'_> {
    pub(super) fn classes(&self, assessable: Assessable) -> ClassesFound {
        let [slope, form, total] = match self.kind {
            Kind::Profile => [Characteristic::ProfileSlope, Characteristic::ProfileForm, Characteristic::ProfileTotal],
            Kind::Helix => [Characteristic::HelixSlope, Characteristic::HelixForm, Characteristic::HelixTotal],
        };
        let (values, whole) = (self.values, assessable == Assessable::Everything);
        let (of_slope, open) = match assessable {
            Assessable::Nothing | Assessable::Figures => return ClassesFound { classes: None, open: None },
            Assessable::Everything => (self.class(slope, values.slope_um), None),
            Assessable::Slope => match self.of_uncertain(slope) {
                Ok(class) => (class, None),
                Err(why) => (None, Some(why)),
            },
        };
        let form = self.class(form, values.form_um).filter(|_| whole);
        let total = self.class(total, values.total_um).filter(|_| whole);
        let any = of_slope.is_some() || form.is_some() || total.is_some();
        let ([slope, form, total], coarser_than_11) = numbered([("slope", of_slope), ("form", form), ("total", total)]);
        ClassesFound { classes: any.then_some(Classes { slope, form, total, coarser_than_11 }), open }
    }

    fn class(&self, characteristic: Characteristic, value: f64) -> Option<Class> {
        self.tolerances.class(characteristic, value, self.rounding)
    }

    /// The class of a slope over a hole, or why it has none.
    fn of_uncertain(&self, slope: Characteristic) -> Result<Option<Class>, TraceWarning> {
        let amount = self.values.slope_um.abs();
        let Some(error) = self.values.slope_std_error_um else {
            return Err(TraceWarning::SlopeClassUnknown);
        };
        let by = |errors: f64| self.class(slope, (amount + errors * error).max(0.0));
        let (least, most) = (by(-SURE), by(SURE));
        if least == most {
            return Ok(most);
        }
        Err(TraceWarning::SlopeClassOpen { slope_um: self.values.slope_um, std_error_um: error })
    }
}
