//! Tolerances of ISO 1328-1:2013.

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize,
    de::{self, Visitor},
};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    faults::Faults,
    gears::gear::GearBody,
    json::{value::read_json, writer},
    problem::Problem,
};
use flankfit_engine::gear::tolerance::{COARSEST, Characteristic, FINEST, OutOfScope, Quantity, Tolerances};

/// A gear and a class.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = TolerancesRequest)]
pub struct TolerancesRequestBody {
    pub gear: GearBody,
    /// Finer classes are smaller.
    #[schema(value_type = u8, minimum = 1, maximum = 11)]
    pub class: ClassNumber,
}

/// A class of the standard, if it is within the range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct ClassNumber(u64);

impl<'de> Deserialize<'de> for ClassNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct AnyClass;

        impl Visitor<'_> for AnyClass {
            type Value = ClassNumber;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a whole number from {FINEST} to {COARSEST}")
            }

            fn visit_u64<E: de::Error>(self, number: u64) -> Result<ClassNumber, E> {
                Ok(ClassNumber(number))
            }
        }

        deserializer.deserialize_u64(AnyClass)
    }
}

/// Tolerances of a class.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = GearTolerances)]
pub struct TolerancesBody {
    /// The requested class, 1 to 11.
    pub class: u8,
    /// Values of the formulas; totals are made of these.
    pub unrounded: ToleranceValuesBody,
    /// Values of the tables in the standard: above 10 µm rounded to 1 µm, from 5 to 10 µm to 0.5
    /// µm, below to 0.1 µm.
    pub rounded: ToleranceValuesBody,
}

/// µm. Those of the helix are left out where the gear has no face width.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ToleranceValues)]
pub struct ToleranceValuesBody {
    /// f_p, single pitch deviation.
    pub single_pitch_um: f64,
    /// F_p, total cumulative pitch (index) deviation.
    pub cumulative_pitch_um: f64,
    /// F_r, run-out.
    pub runout_um: f64,
    /// f_Hα, profile slope deviation.
    pub profile_slope_um: f64,
    /// f_fα, profile form deviation.
    pub profile_form_um: f64,
    /// F_α, total profile deviation.
    pub profile_total_um: f64,
    /// f_Hβ, helix slope deviation. Absent where the gear has no face width.
    pub helix_slope_um: Option<f64>,
    /// f_fβ, helix form deviation. Absent where the gear has no face width.
    pub helix_form_um: Option<f64>,
    /// F_β, total helix deviation. Absent where the gear has no face width.
    pub helix_total_um: Option<f64>,
}

/// Responds to a request. There are no tolerances outside the scope of the standard: every quantity
/// outside it is an error.
pub fn answer(text: &[u8]) -> Result<Vec<u8>, Problem> {
    let TolerancesRequestBody { gear, class: ClassNumber(class) } = read_json(text)?;
    let mut faults = Faults::default();
    let known = u8::try_from(class).ok().filter(|class| (FINEST..=COARSEST).contains(class));
    if known.is_none() {
        faults.push("/class", format!("{class} is not one of {FINEST} to {COARSEST}"));
    }
    let gear = gear.checked("/gear").map_err(|more| faults.append(more)).ok();
    let tolerances = gear.and_then(|gear| {
        let outside = |out: OutOfScope| {
            let why = out.to_string();
            out.outside.iter().for_each(|excess| faults.push(place(excess.quantity), why.clone()));
        };
        Tolerances::new(&gear).map_err(outside).ok()
    });
    let tolerances = faults.into_result(tolerances).map_err(Problem::invalid)?;
    let values = tolerances.zip(known).and_then(|(tolerances, class)| {
        let unrounded = values(|characteristic| tolerances.unrounded(characteristic, class))?;
        let rounded = values(|characteristic| tolerances.rounded(characteristic, class))?;
        Some(TolerancesBody { class, unrounded, rounded })
    });
    let values = values.ok_or_else(|| Problem::internal("tolerances without a value"))?;
    writer::whole(&values).map_err(Problem::not_finite)
}

/// Returns the pointer of the field that determines a quantity.
fn place(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Teeth | Quantity::ReferenceDiameter => "/gear/teeth",
        Quantity::NormalModule => "/gear/normal_module_mm",
        Quantity::FaceWidth => "/gear/face_width_mm",
        Quantity::HelixAngle => "/gear/helix_angle_deg",
    }
}

fn values(of: impl Fn(Characteristic) -> Option<f64>) -> Option<ToleranceValuesBody> {
    Some(ToleranceValuesBody {
        single_pitch_um: of(Characteristic::SinglePitch)?,
        cumulative_pitch_um: of(Characteristic::CumulativePitch)?,
        runout_um: of(Characteristic::Runout)?,
        profile_slope_um: of(Characteristic::ProfileSlope)?,
        profile_form_um: of(Characteristic::ProfileForm)?,
        profile_total_um: of(Characteristic::ProfileTotal)?,
        helix_slope_um: of(Characteristic::HelixSlope),
        helix_form_um: of(Characteristic::HelixForm),
        helix_total_um: of(Characteristic::HelixTotal),
    })
}
