//! The part of the flank that amounts of modifications refer to.

use super::LEAST_LENGTH;
use crate::{Gear, Geometry};
use flankfit_numerics::{
    check::Faults,
    words::{Shown, rounded},
};

/// Ends of profile and face width, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Roll length at the root end and at the tip end; the second is the smaller one on internal
    /// gears.
    profile: [f64; 2],
    /// z, ascending.
    helix: [f64; 2],
}

impl Range {
    /// From two diameters (in any order) and two z (in any order).
    pub fn new(gear: &Gear, diameters: [f64; 2], helix: [f64; 2]) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        let mut profile = [0.0; 2];
        for (index, diameter) in diameters.into_iter().enumerate() {
            match gear.roll_length(diameter).filter(|roll| roll.is_finite()) {
                Some(roll) => profile[index] = roll,
                None => {
                    let [diameter, base] = [diameter, 2.0 * gear.base_radius()].map(|x| rounded(x, 7));
                    faults.push(
                        format_args!("profile_diameter_range_mm[{index}]"),
                        format_args!("{diameter} mm has no involute; the base diameter is {base} mm"),
                    );
                }
            }
        }
        if faults.is_empty() && !((profile[0] - profile[1]).abs() >= LEAST_LENGTH) {
            let message = format_args!("their roll lengths are less than {LEAST_LENGTH} mm apart");
            faults.push("profile_diameter_range_mm", message);
        }
        if let Some(index) = helix.iter().position(|z| !(z.abs() <= 1e6)) {
            let path = format_args!("helix_range_mm[{index}]");
            faults.push(path, format_args!("{} is not a place on the axis", Shown(helix[index])));
        } else if !((helix[0] - helix[1]).abs() >= LEAST_LENGTH) {
            faults.push("helix_range_mm", format_args!("the two ends are less than {LEAST_LENGTH} mm apart"));
        }
        if (profile[1] - profile[0]) * gear.outward() < 0.0 {
            profile.reverse();
        }
        faults.into_result(Range { profile, helix: [helix[0].min(helix[1]), helix[0].max(helix[1])] })
    }

    /// From two roll lengths (in any order) and two z (in any order).
    pub fn of_roll_lengths(gear: &Gear, roll_lengths: [f64; 2], helix: [f64; 2]) -> Result<Self, Faults> {
        Range::new(gear, roll_lengths.map(|roll| gear.diameter(roll)), helix)
    }

    /// The whole usable profile, and the face width from z = 0; `None` where there is no usable
    /// profile, or the width is not given.
    pub fn whole(gear: &Gear) -> Option<Self> {
        let usable = Geometry::of(gear).usable_profile?;
        Some(Range { profile: usable.roll_lengths_mm, helix: [0.0, gear.data().face_width?] })
    }

    /// Roll lengths at the root end and at the tip end.
    pub fn profile(&self) -> [f64; 2] {
        self.profile
    }

    /// z of both ends, ascending.
    pub fn helix(&self) -> [f64; 2] {
        self.helix
    }

    /// −1 at the root end, +1 at the tip end.
    pub fn u(&self, roll_length: f64) -> f64 {
        let [a, b] = self.profile;
        ((roll_length - a) + (roll_length - b)) / (b - a)
    }

    /// du/dL.
    pub fn u_slope(&self) -> f64 {
        2.0 / (self.profile[1] - self.profile[0])
    }

    /// −1 at the end of lower z, +1 at the other.
    pub fn v(&self, z: f64) -> f64 {
        let [a, b] = self.helix;
        ((z - a) + (z - b)) / (b - a)
    }

    /// dv/dz.
    pub fn v_slope(&self) -> f64 {
        2.0 / (self.helix[1] - self.helix[0])
    }
}
