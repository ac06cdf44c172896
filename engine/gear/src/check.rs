//! Checks that a gear with given data can exist, and checks of its numbers by themselves.

use std::f64::consts::PI;

use super::{
    Gear, GearData, Side, Tool,
    data::{HELIX_ANGLES, LEAST_LENGTH, MOST_LENGTH, PRESSURE_ANGLES},
    generation::rack,
    involute::Flank,
};
use flankfit_numerics::{
    check::Faults,
    words::{Shown, counted, rounded},
};

/// Most teeth of a gear.
pub const MOST_TEETH: u32 = 10_000;

impl Gear {
    /// Checks the data, and what follows from them.
    pub fn new(data: GearData) -> Result<Self, Faults> {
        check(&data)?;
        let gear = Gear::derived(data);
        gear.check_circles()?;
        gear.check_tooth()?;
        rack::check(&gear)?;
        Ok(gear)
    }

    /// Between root and tip there must be a tooth and a space.
    fn check_tooth(&self) -> Result<(), Faults> {
        let flank = Flank::new(self, Side::Left);
        let half_tooth = |radius: f64| flank.half_angle(self.roll_length(2.0 * radius).unwrap_or(0.0));
        // Teeth get thinner outwards on external gears and inwards on internal ones, the spaces the
        // other way.
        let inner = if self.data().internal { self.tip_radius() } else { self.root_radius() };
        let outer = if self.data().internal { self.root_radius() } else { self.tip_radius() };
        let (thick, wide) = if self.data().internal { (outer, inner) } else { (inner, outer) };
        let mut faults = Faults::default();
        if !(half_tooth(thick) > 0.0) {
            let diameter = rounded(2.0 * thick, 7);
            faults.push(
                "profile_shift_coefficient",
                format_args!("the flanks of a tooth meet before the root: there is no tooth on {diameter} mm"),
            );
        }
        if !(half_tooth(wide) < PI / self.teeth()) {
            faults.push("profile_shift_coefficient", no_space(2.0 * wide));
        }
        faults.into_result(())
    }

    /// Circles that leave no involute between them.
    fn check_circles(&self) -> Result<(), Faults> {
        let (tip, root, base) = (self.tip_radius(), self.root_radius(), self.base_radius());
        let mut faults = Faults::default();
        let internal = self.data().internal;
        let crossed = if internal { tip >= root } else { tip <= root };
        let no_involute = |name: &str, diameter: f64| {
            let [diameter, base] = [diameter, 2.0 * base].map(|x| rounded(x, 7));
            format!("the {name} diameter {diameter} mm is not above the base circle of {base} mm: there is no involute")
        };
        let (tip_diameter, root_diameter) = (2.0 * tip, 2.0 * root);
        if crossed {
            let greater = if internal { "smaller" } else { "greater" };
            let [tip, root] = [tip_diameter, root_diameter].map(|x| rounded(x, 7));
            faults.push(
                self.given_circle(),
                format_args!("the tip diameter {tip} mm is not {greater} than the root diameter {root} mm"),
            );
        } else if !internal && tip <= base {
            faults.push(self.given_circle(), no_involute("tip", tip_diameter));
        } else if internal && root <= base {
            faults.push(self.given_circle(), no_involute("root", root_diameter));
        }
        if !(root > 0.0) && self.data().root_diameter.is_none() {
            faults
                .push("profile_shift_coefficient", "the resulting root circle is not above 0; give `root_diameter_mm`");
        }
        faults.into_result(())
    }
}

/// The message of teeth that touch each other on a diameter, mm.
pub(crate) fn no_space(diameter: f64) -> String {
    format!("there is no space between the teeth on {} mm", rounded(diameter, 7))
}

/// Checks a number of teeth.
pub fn teeth(value: f64) -> Result<(), String> {
    let is_number = (1.0..=f64::from(MOST_TEETH)).contains(&value);
    accept(is_number, || format!("{}; a gear has 1 to {MOST_TEETH}", counted(value as usize, "tooth", "teeth")))
}

/// Checks a length of a gear, mm.
pub fn length(value: f64) -> Result<(), String> {
    let is_length = (LEAST_LENGTH..=MOST_LENGTH).contains(&value);
    accept(is_length, || format!("{} mm is not a length of a µm to a kilometre", Shown(value)))
}

/// Checks α_n, rad.
pub fn pressure_angle(value: f64) -> Result<(), String> {
    angle(value, PRESSURE_ANGLES, PRESSURE_ANGLES)
}

/// Checks the size of β, rad. The range of the message has a sign, by which callers tell the hand.
pub fn helix_angle(value: f64) -> Result<(), String> {
    angle(value, HELIX_ANGLES, [-HELIX_ANGLES[1], HELIX_ANGLES[1]])
}

fn angle(value: f64, range: [f64; 2], [low, high]: [f64; 2]) -> Result<(), String> {
    let [from, to] = range.map(f64::to_radians);
    accept((from..to).contains(&value), || format!("{}° is not within {low}° and {high}°", degrees(value)))
}

/// Checks a profile shift coefficient.
pub fn profile_shift(value: f64) -> Result<(), String> {
    accept(value.abs() <= 100.0, || format!("{} is not within −100 and 100", Shown(value)))
}

/// Checks a radius, a factor or a length of a tool.
pub fn tool_part(value: f64) -> Result<(), String> {
    accept((0.0..=MOST_LENGTH).contains(&value), || format!("{} is not within 0 and 1000000", Shown(value)))
}

fn accept(good: bool, message: impl FnOnce() -> String) -> Result<(), String> {
    if good { Ok(()) } else { Err(message()) }
}

/// An angle in few digits: on the way to radians and back the last ones of what was sent change.
pub(crate) fn degrees(radians: f64) -> Shown {
    let back = radians.to_degrees();
    let shown = |digits| rounded(back, digits);
    (1..=16).map(shown).find(|sent| sent.0.to_radians() == radians).unwrap_or_else(|| shown(13))
}

fn check(data: &GearData) -> Result<(), Faults> {
    let optional = |value: Option<f64>, check: fn(f64) -> Result<(), String>| value.map_or(Ok(()), check);
    let tool = |part: fn(&Tool) -> f64| optional(data.tool.as_ref().map(part), tool_part);
    let checked = [
        ("teeth", teeth(f64::from(data.teeth))),
        ("normal_module_mm", length(data.normal_module)),
        ("face_width_mm", optional(data.face_width, length)),
        ("tip_diameter_mm", optional(data.tip_diameter, length)),
        ("root_diameter_mm", optional(data.root_diameter, length)),
        ("normal_pressure_angle_deg", pressure_angle(data.pressure_angle)),
        ("helix_angle_deg", helix_angle(data.helix_angle)),
        ("profile_shift_coefficient", profile_shift(data.profile_shift)),
        ("tool.tip_radius_mm", tool(|tool| tool.tip_radius)),
        ("tool.addendum_factor", tool(|tool| tool.addendum_factor)),
        ("tool.protuberance_mm", tool(|tool| tool.protuberance)),
    ];
    let mut faults = Faults::default();
    for (path, checked) in checked {
        if let Err(message) = checked {
            faults.push(path, message);
        }
    }
    faults.into_result(())
}

#[cfg(test)]
mod tests {
    use super::degrees;

    #[test]
    fn angles_are_shown_in_few_digits() {
        for sent in [1000.0_f64, 20.0, 91.3, 0.1, -45.123_456] {
            assert_eq!(degrees(sent.to_radians()).to_string(), sent.to_string());
        }
        // radians that no number of degrees of sixteen digits gives
        let odd = 17.453_292_519_943_3_f64;
        assert!(degrees(odd).to_string().len() <= 16, "{}", degrees(odd));
        assert_eq!(degrees(f64::NAN).to_string(), "NaN");
    }
}
