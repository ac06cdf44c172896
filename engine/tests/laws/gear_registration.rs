//! Gears and measured points for the laws of deviations and of their registration.

use crate::oracle::random::Random;
use flankfit_engine::gear::{Gear, GearData, Hand, Side, involute::Flank};
use flankfit_engine::geometry::space::Vector;
use std::f64::consts::TAU;

/// A gear of ordinary size; every third one is internal, every fourth one spur.
pub fn gear(seed: u64) -> Gear {
    let mut random = Random::new(seed);
    let internal = random.below(3) == 0;
    Gear::new(GearData {
        teeth: if internal { 40 + random.below(60) as u32 } else { 12 + random.below(60) as u32 },
        normal_module: random.between(1.0, 5.0),
        pressure_angle: random.between(15.0, 25.0).to_radians(),
        helix_angle: if random.below(4) == 0 { 0.0 } else { random.between(5.0, 35.0).to_radians() },
        hand: if random.below(2) == 0 { Hand::Right } else { Hand::Left },
        profile_shift: random.between(-0.1, 0.4),
        face_width: None,
        tip_diameter: None,
        root_diameter: None,
        internal,
        tool: None,
    })
    .expect("an ordinary gear")
}

/// An external helical gear, z = 31, m_n = 3 mm.
pub fn helical(helix_angle_deg: f64, hand: Hand) -> Gear {
    Gear::new(GearData {
        teeth: 31,
        normal_module: 3.0,
        pressure_angle: 20f64.to_radians(),
        helix_angle: helix_angle_deg.to_radians(),
        hand,
        profile_shift: 0.2,
        face_width: Some(30.0),
        tip_diameter: None,
        root_diameter: None,
        internal: false,
        tool: None,
    })
    .expect("an ordinary gear")
}

/// Roll lengths of the flank, away from the base circle.
pub fn rolls(gear: &Gear) -> [f64; 2] {
    let at = |radius: f64| gear.roll_length(2.0 * radius).unwrap_or(0.0);
    let (a, b) = (at(gear.tip_radius()), at(gear.root_radius()));
    let (low, high) = (a.min(b), a.max(b));
    [low.max(0.1 * high), high]
}

pub fn side(k: usize) -> Side {
    if k.is_multiple_of(2) { Side::Left } else { Side::Right }
}

/// The place `distance` mm above a flank of a tooth, from 1 clockwise.
pub fn above(gear: &Gear, tooth: u32, side: Side, roll_length: f64, z: f64, distance: f64) -> Vector {
    let place = Flank::new(gear, side).at(roll_length, z);
    let point = place.point + place.normal * distance;
    let (sin, cos) = (TAU * (1.0 - f64::from(tooth)) / gear.teeth()).sin_cos();
    Vector::new(cos * point.x - sin * point.y, sin * point.x + cos * point.y, point.z)
}
