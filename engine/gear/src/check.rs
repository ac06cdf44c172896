//! Checks that a gear with given data can exist.

use std::f64::consts::PI;

use super::{
    Gear, GearData, Side, Tool,
    data::{HELIX_ANGLES, LEAST_LENGTH, MOST_LENGTH, PRESSURE_ANGLES},
    fault::{GearFaults, GearField, GearReason, MOST_TEETH},
    generation::rack,
    involute::Flank,
};

impl Gear {
    /// Checks the data, and what follows from them.
    pub fn new(data: GearData) -> Result<Self, GearFaults> {
        check(&data)?;
        let gear = Gear::derived(data);
        gear.check_circles()?;
        gear.check_tooth()?;
        rack::check(&gear)?;
        Ok(gear)
    }

    /// Between root and tip there must be a tooth, and a space beside it.
    fn check_tooth(&self) -> Result<(), GearFaults> {
        let flank = Flank::new(self, Side::Left);
        let half_tooth = |radius: f64| flank.half_angle(self.roll_length(2.0 * radius).unwrap_or(0.0));
        // Teeth get thinner outwards on external gears and inwards on internal ones, the spaces the
        // other way.
        let inner = if self.data().internal { self.tip_radius() } else { self.root_radius() };
        let outer = if self.data().internal { self.root_radius() } else { self.tip_radius() };
        let (thick, wide) = if self.data().internal { (outer, inner) } else { (inner, outer) };
        let mut faults = GearFaults::default();
        if !(half_tooth(thick) > 0.0) {
            faults.push(GearField::ProfileShift, GearReason::NoTooth(2.0 * thick));
        }
        if !(half_tooth(wide) < PI / self.teeth()) {
            faults.push(GearField::ProfileShift, GearReason::NoSpace(2.0 * wide));
        }
        faults.into_result(())
    }

    /// Circles that leave no involute between them.
    fn check_circles(&self) -> Result<(), GearFaults> {
        let (tip, root, base) = (self.tip_radius(), self.root_radius(), self.base_radius());
        let mut faults = GearFaults::default();
        let internal = self.data().internal;
        let crossed = if internal { tip >= root } else { tip <= root };
        let (tip, root_diameter, base) = (2.0 * tip, 2.0 * root, 2.0 * base);
        if crossed {
            faults.push(self.given_circle(), GearReason::TipAndRoot { tip, root: root_diameter, internal });
        } else if !internal && tip <= base {
            faults.push(self.given_circle(), GearReason::TipWithinBase { tip, base });
        } else if internal && root_diameter <= base {
            faults.push(self.given_circle(), GearReason::RootWithinBase { root: root_diameter, base });
        }
        if !(root > 0.0) && self.data().root_diameter.is_none() {
            faults.push(GearField::ProfileShift, GearReason::NoRoot);
        }
        faults.into_result(())
    }
}

impl GearField {
    /// What is wrong with its number by itself; lengths in mm, angles in rad.
    pub fn check(self, value: f64) -> Result<(), GearReason> {
        let angle = |[low, high]: [f64; 2]| {
            let [low, high] = [low.to_radians(), high.to_radians()];
            (!(low..high).contains(&value)).then_some(GearReason::Angle { value, low, high })
        };
        let fault = match self {
            GearField::Teeth => {
                (!(1.0..=f64::from(MOST_TEETH)).contains(&value)).then_some(GearReason::Teeth(value as u32))
            }
            GearField::NormalModule | GearField::FaceWidth | GearField::TipDiameter | GearField::RootDiameter => {
                (!(LEAST_LENGTH..=MOST_LENGTH).contains(&value)).then_some(GearReason::Length(value))
            }
            GearField::PressureAngle => angle(PRESSURE_ANGLES),
            GearField::HelixAngle => angle(HELIX_ANGLES),
            GearField::ProfileShift => (!(value.abs() <= 100.0)).then_some(GearReason::ProfileShift(value)),
            GearField::ToolTipRadius | GearField::ToolAddendum | GearField::ToolProtuberance => {
                (!(0.0..=MOST_LENGTH).contains(&value)).then_some(GearReason::ToolPart(value))
            }
            GearField::Tool => None,
        };
        fault.map_or(Ok(()), Err)
    }
}

fn check(data: &GearData) -> Result<(), GearFaults> {
    let tool = |part: fn(&Tool) -> f64| data.tool.as_ref().map(part);
    let numbers = [
        (GearField::Teeth, Some(f64::from(data.teeth))),
        (GearField::NormalModule, Some(data.normal_module)),
        (GearField::FaceWidth, data.face_width),
        (GearField::TipDiameter, data.tip_diameter),
        (GearField::RootDiameter, data.root_diameter),
        (GearField::PressureAngle, Some(data.pressure_angle)),
        (GearField::HelixAngle, Some(data.helix_angle)),
        (GearField::ProfileShift, Some(data.profile_shift)),
        (GearField::ToolTipRadius, tool(|tool| tool.tip_radius)),
        (GearField::ToolAddendum, tool(|tool| tool.addendum_factor)),
        (GearField::ToolProtuberance, tool(|tool| tool.protuberance)),
    ];
    let mut faults = GearFaults::default();
    for (field, value) in numbers {
        if let Some(Err(reason)) = value.map(|value| field.check(value)) {
            faults.push(field, reason);
        }
    }
    faults.into_result(())
}
