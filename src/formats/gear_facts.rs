//! What a file says of its gear: perhaps all of it, perhaps not.

use crate::gear::{GearData, Hand};

/// A datum that a gear cannot be without, by its name on the interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Datum {
    Teeth,
    NormalModule,
    PressureAngle,
    HelixAngle,
    /// Of a helical gear.
    Hand,
    ProfileShift,
}

impl Datum {
    /// The name of the field in a gear's data.
    pub fn as_str(self) -> &'static str {
        match self {
            Datum::Teeth => "teeth",
            Datum::NormalModule => "normal_module_mm",
            Datum::PressureAngle => "normal_pressure_angle_deg",
            Datum::HelixAngle => "helix_angle_deg",
            Datum::Hand => "hand",
            Datum::ProfileShift => "profile_shift_coefficient",
        }
    }
}

/// A gear's data as far as a file gives them. Lengths mm, angles rad.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GearFacts {
    pub teeth: Option<u32>,
    pub normal_module: Option<f64>,
    pub pressure_angle: Option<f64>,
    /// β ≥ 0; its sign is the hand.
    pub helix_angle: Option<f64>,
    pub hand: Option<Hand>,
    pub profile_shift: Option<f64>,
    pub face_width: Option<f64>,
    pub tip_diameter: Option<f64>,
    pub root_diameter: Option<f64>,
    /// `None`: the file does not say; its gear is taken for an external one unless its tip circle is the smaller.
    pub internal: Option<bool>,
}

impl GearFacts {
    /// Takes a helix angle with its sign, rad: right-hand helices are positive (ISO 21771). A hand that is already known stays.
    pub(super) fn set_helix_angle(&mut self, angle: f64) {
        self.helix_angle = Some(angle.abs());
        if angle < 0.0 && self.hand.is_none() {
            self.hand = Some(Hand::Left);
        }
    }

    /// Whether teeth point inwards.
    pub fn is_internal(&self) -> bool {
        let inwards = self.tip_diameter.zip(self.root_diameter).is_some_and(|(tip, root)| tip < root);
        self.internal.unwrap_or(inwards)
    }

    /// What is missing for a gear. The hand is asked for only where the helix has an angle.
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

    /// The data of a gear, not yet checked ([`crate::gear::Gear::new`] does that), or what is missing. A spur gear gets the right hand,
    /// which means nothing there.
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

/// Degrees of a file as rad: one rounding, so that 20 is the very double that the interface makes of 20.
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
    fn a_gear_or_what_it_lacks() {
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
