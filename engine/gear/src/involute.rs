//! The involute helicoid: points, normals and where on a tooth they lie.
//!
//! The involute of a flank starts on the base circle at the angle `s (ψ + τ inv α_t)` from the
//! tooth's middle, counterclockwise (s = ±1 for the left and right flank, τ = ±1 for external and
//! internal gears), and unrolls in the direction −σ, σ = s τ. With the base tangent point at the
//! angle `χ = s (ψ + τ inv α_t) − σ ξ + turn(z)`, ξ = L / r_b:
//!
//! `P = r_b e_r(χ) + σ L e_t(χ) + z e_z`, normal `n = s (cos β_b e_t(χ) − h sin β_b e_z)`
//!
//! with e_r = (−sin χ, cos χ), e_t = (−cos χ, −sin χ) and h = ±1 for a right- and a left-hand
//! helix. For external gears these are the printed forms of ISO 21771 and of Litvin; the normal
//! points out of the material.

use super::{Gear, Side};
use flankfit_geometry::space::Vector;

/// inv α = tan α − α for the roll angle ξ = tan α, without cancellation near 0 (a few units of the
/// last place everywhere).
///
/// ```
/// use flankfit_gear::involute::inv_of_roll;
///
/// // inv 20° = 0.014904…, as tables have it.
/// assert!((inv_of_roll(20_f64.to_radians().tan()) - 0.014_904_38).abs() < 1e-8);
/// ```
pub fn inv_of_roll(roll: f64) -> f64 {
    if roll.abs() < 0.5 {
        // ξ − arctan ξ = ξ³/3 − ξ⁵/5 + …, whose terms after these are below the last place of the
        // first.
        let square = roll * roll;
        let mut sum = 0.0;
        for k in (1..=28).rev() {
            let term = 1.0 / f64::from(2 * k + 1);
            sum = term - square * sum;
        }
        roll * square * sum
    } else {
        roll - roll.atan()
    }
}

/// The roll angle ξ ≥ 0 with ξ − arctan ξ = `involute`, for `involute` ≥ 0.
///
/// The function is convex: Newton's iteration from the lower bound ∛(3 inv) passes the root at most
/// once and comes down to it.
///
/// ```
/// use flankfit_gear::involute::{inv_of_roll, roll_of_inv};
///
/// assert!((roll_of_inv(inv_of_roll(0.5)) - 0.5).abs() < 1e-15);
/// ```
pub fn roll_of_inv(involute: f64) -> f64 {
    let mut roll = (3.0 * involute).cbrt();
    if !(roll > 0.0) {
        return 0.0;
    }
    for _ in 0..60 {
        let step = (inv_of_roll(roll) - involute) * (1.0 + 1.0 / (roll * roll));
        roll -= step;
        if step.abs() <= 2.0 * f64::EPSILON * roll {
            break;
        }
    }
    roll
}

/// A flank of the tooth at the top.
#[derive(Clone, Copy, Debug)]
pub struct Flank<'a> {
    /// The gear.
    pub gear: &'a Gear,
    /// Which flank of the tooth.
    pub side: Side,
    start_angle: f64,
}

/// A place on a flank with the normal out of the material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlankPoint {
    /// mm.
    pub point: Vector,
    /// Unit normal.
    pub normal: Vector,
}

impl<'a> Flank<'a> {
    /// The left or right flank of the tooth at the top.
    pub fn new(gear: &'a Gear, side: Side) -> Self {
        let involute = inv_of_roll(gear.transverse_pressure_angle().tan());
        let start_angle = side.sign() * (gear.half_tooth_angle() + gear.outward() * involute);
        Flank { gear, side, start_angle }
    }

    /// σ: +1 where the involute unrolls clockwise.
    pub fn sense(&self) -> f64 {
        self.side.sign() * self.gear.outward()
    }

    /// Angle of the involute's start on the base circle of z = 0, rad counterclockwise from the
    /// tooth's middle.
    pub fn start_angle(&self) -> f64 {
        self.start_angle
    }

    /// Half the tooth's angle at a roll length, rad; negative above the tip of a pointed tooth.
    pub fn half_angle(&self, roll_length: f64) -> f64 {
        let inv = inv_of_roll(roll_length / self.gear.base_radius());
        self.side.sign() * self.start_angle() - self.gear.outward() * inv
    }

    /// The base tangent point's angle χ at a roll length and a z, rad counterclockwise from the
    /// tooth's middle at z = 0.
    pub fn tangent_angle(&self, roll_length: f64, z: f64) -> f64 {
        let gear = self.gear;
        self.start_angle - self.sense() * roll_length / gear.base_radius() + gear.turn_per_length() * z
    }

    /// The place at a roll length and a z, both mm.
    ///
    /// ```
    /// use flankfit_gear::{Gear, GearData, Side, involute::Flank};
    ///
    /// // The normal of an involute touches the base circle, at the distance of the roll length.
    /// let gear = Gear::new(GearData::spur(52, 1.0))?;
    /// let place = Flank::new(&gear, Side::Left).at(9.0, 0.0);
    /// let (rb, r) = (gear.base_radius(), place.point.norm());
    /// assert!((r * r - rb * rb - 81.0).abs() < 1e-10);
    /// let touch = [1.0, -1.0].map(|way| (place.point + way * 9.0 * place.normal).norm());
    /// assert!(touch.iter().any(|radius| (radius - rb).abs() < 1e-12));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn at(&self, roll_length: f64, z: f64) -> FlankPoint {
        let gear = self.gear;
        let (r, sense) = (gear.base_radius(), self.sense());
        let (sin, cos) = self.tangent_angle(roll_length, z).sin_cos();
        let (along, side) = (sense * roll_length, self.side.sign());
        let (sin_b, cos_b) = gear.base_helix_angle().sin_cos();
        FlankPoint {
            point: Vector::new(-r * sin - along * cos, r * cos - along * sin, z),
            normal: Vector::new(-side * cos_b * cos, -side * cos_b * sin, -side * gear.hand() * sin_b),
        }
    }
}
