//! Data of a gear in a file, complete or not.

use flankfit_gear::{GearData, Hand};
use flankfit_numerics::words::Shown;

/// A datum of a gear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Datum {
    /// Number of teeth.
    Teeth,
    /// Normal module.
    NormalModule,
    /// Normal pressure angle.
    PressureAngle,
    /// Helix angle.
    HelixAngle,
    /// Hand of a helical gear.
    Hand,
    /// Profile shift coefficient.
    ProfileShift,
    /// Face width.
    FaceWidth,
    /// Tip diameter.
    TipDiameter,
    /// Root diameter.
    RootDiameter,
    /// Direction of the teeth, inwards or outwards.
    Internal,
}

/// A gear's data as far as a file gives them. Lengths mm, angles rad.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GearFacts {
    /// Number of teeth z.
    pub teeth: Option<u32>,
    /// Normal module m_n.
    pub normal_module: Option<f64>,
    /// Normal pressure angle α_n.
    pub pressure_angle: Option<f64>,
    /// β ≥ 0; its sign is the hand.
    pub helix_angle: Option<f64>,
    /// Direction of the helix.
    pub hand: Option<Hand>,
    /// Profile shift coefficient x, positive towards the tip.
    pub profile_shift: Option<f64>,
    /// Face width b.
    pub face_width: Option<f64>,
    /// Tip diameter d_a.
    pub tip_diameter: Option<f64>,
    /// Root diameter d_f.
    pub root_diameter: Option<f64>,
    /// `None`: the file does not say; its gear is taken for an external one unless its tip circle
    /// is the smaller.
    pub internal: Option<bool>,
}

/// A datum that a file gives otherwise than a gear has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Datum that differs.
    pub datum: Datum,
    /// Its value in the file, as text.
    pub file: String,
    /// Its value of the gear, as text.
    pub gear: String,
    /// True if the difference is one of another gear, which no rounding or convention explains.
    pub another: bool,
}

impl GearFacts {
    /// Differences between a file and a gear in what both have, by more than a file's last digits:
    /// a thousandth of lengths and of the profile shift coefficient's unit, a fiftieth of a degree.
    pub fn differences(&self, gear: &GearData) -> Vec<Difference> {
        let mut found = Vec::new();
        let mut differ = |datum, file: String, gear: String, another| {
            found.push(Difference { datum, file, gear, another });
        };
        if let Some(teeth) = self.teeth.filter(|teeth| *teeth != gear.teeth) {
            differ(Datum::Teeth, teeth.to_string(), gear.teeth.to_string(), true);
        }
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-3 * a.abs().max(b.abs());
        for (datum, file, of_gear, another) in [
            (Datum::NormalModule, self.normal_module, Some(gear.normal_module), true),
            (Datum::FaceWidth, self.face_width, gear.face_width, false),
            (Datum::TipDiameter, self.tip_diameter, gear.tip_diameter, false),
            (Datum::RootDiameter, self.root_diameter, gear.root_diameter, false),
        ] {
            if let (Some(file), Some(of_gear)) = (file, of_gear)
                && !near(file, of_gear)
            {
                differ(datum, Shown(file).to_string(), Shown(of_gear).to_string(), another);
            }
        }
        for (datum, file, of_gear) in [
            (Datum::PressureAngle, self.pressure_angle, gear.pressure_angle),
            (Datum::HelixAngle, self.helix_angle, gear.helix_angle),
        ] {
            let Some(file) = file.map(f64::to_degrees) else { continue };
            let of_gear = of_gear.to_degrees();
            if (file - of_gear).abs() > 0.02 {
                differ(datum, format!("{file:.4}"), format!("{of_gear:.4}"), (file - of_gear).abs() > 0.5);
            }
        }
        if let Some(shift) = self.profile_shift.filter(|shift| (shift - gear.profile_shift).abs() > 1e-3) {
            differ(Datum::ProfileShift, Shown(shift).to_string(), Shown(gear.profile_shift).to_string(), false);
        }
        let word = |hand| if hand == Hand::Right { "right" } else { "left" };
        if let Some(hand) = self.hand.filter(|hand| *hand != gear.hand && gear.helix_angle > 0.0) {
            differ(Datum::Hand, word(hand).to_owned(), word(gear.hand).to_owned(), true);
        }
        if let Some(internal) = self.internal.filter(|internal| *internal != gear.internal) {
            differ(Datum::Internal, internal.to_string(), gear.internal.to_string(), true);
        }
        found
    }

    /// Takes a helix angle with its sign, rad: right-hand helices are positive (ISO 21771). A hand
    /// that is already known stays.
    pub(super) fn set_helix_angle(&mut self, angle: f64) {
        self.helix_angle = Some(angle.abs());
        if angle < 0.0 && self.hand.is_none() {
            self.hand = Some(Hand::Left);
        }
    }

    /// True if teeth point inwards.
    pub fn is_internal(&self) -> bool {
        let inwards = self.tip_diameter.zip(self.root_diameter).is_some_and(|(tip, root)| tip < root);
        self.internal.unwrap_or(inwards)
    }

    /// Data missing for a gear. The hand is required only if the helix has an angle.
    pub fn missing(&self) -> Vec<Datum> {
        let helical = self.helix_angle.is_some_and(|angle| angle > 0.0);
        let present = [
            (Datum::Teeth, self.teeth.is_some()),
            (Datum::NormalModule, self.normal_module.is_some()),
            (Datum::PressureAngle, self.pressure_angle.is_some()),
            (Datum::HelixAngle, self.helix_angle.is_some()),
            (Datum::Hand, self.hand.is_some() || !helical),
            (Datum::ProfileShift, self.profile_shift.is_some()),
        ];
        present.into_iter().filter(|(_, present)| !present).map(|(datum, _)| datum).collect()
    }

    /// The data of a gear, not yet checked ([`flankfit_gear::Gear::new`] does that), or what is
    /// missing. A spur gear gets the right hand, which means nothing there.
    pub fn gear_data(&self) -> Result<GearData, Vec<Datum>> {
        let (Some(teeth), Some(normal_module), Some(pressure_angle), Some(helix_angle), Some(profile_shift)) =
            (self.teeth, self.normal_module, self.pressure_angle, self.helix_angle, self.profile_shift)
        else {
            return Err(self.missing());
        };
        let hand = match self.hand {
            Some(hand) => hand,
            None if helix_angle == 0.0 => Hand::Right,
            None => return Err(self.missing()),
        };
        Ok(GearData {
            teeth,
            normal_module,
            pressure_angle,
            helix_angle,
            hand,
            profile_shift,
            face_width: self.face_width,
            tip_diameter: self.tip_diameter,
            root_diameter: self.root_diameter,
            internal: self.is_internal(),
            tool: None,
        })
    }
}

/// Degrees of a file as rad: one rounding, so that 20 is the very double that a caller makes
/// of 20.
pub(super) fn radians(degrees: f64) -> f64 {
    degrees.to_radians()
}

/// A number of teeth: whole, not 0; internal gears may be written with a negative one.
pub(super) fn teeth(value: f64) -> Option<u32> {
    let size = value.abs();
    (size.fract() == 0.0 && size >= 1.0 && size <= f64::from(u32::MAX)).then_some(size as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_facts_of_a_gear_are_named() {
        let mut facts = GearFacts { teeth: teeth(-52.0), normal_module: Some(1.0), ..GearFacts::default() };
        assert_eq!(facts.missing(), [Datum::PressureAngle, Datum::HelixAngle, Datum::ProfileShift]);
        facts.pressure_angle = Some(radians(20.0));
        facts.profile_shift = Some(0.011);
        facts.helix_angle = Some(0.1);
        assert_eq!(facts.gear_data().unwrap_err(), [Datum::Hand]);
        facts.set_helix_angle(-0.1);
        assert_eq!(facts.gear_data().unwrap().hand, Hand::Left);
        facts.hand = None;
        facts.set_helix_angle(0.0);
        let data = facts.gear_data().unwrap();
        assert_eq!((data.teeth, data.hand, data.internal), (52, Hand::Right, false));
        facts.tip_diameter = Some(50.0);
        facts.root_diameter = Some(54.0);
        assert!(facts.gear_data().unwrap().internal);
        assert_eq!([teeth(0.0), teeth(1.5), teeth(f64::NAN), teeth(1e300)], [None; 4]);
        assert!((radians(180.0) - std::f64::consts::PI).abs() < 1e-15);
    }
}
