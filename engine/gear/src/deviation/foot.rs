//! The foot of a point on the involute helicoid and its signed distance along the normal, in closed
//! form.
//!
//! Surfaces at a constant distance δ from an involute helicoid are the same helicoid, turned: with
//! the notation of [`crate::involute`],
//!
//! `P(χ, L, z) + δ n = r_b e_r(χ) + (σL + sδ cos β_b) e_t(χ) + (z − s h δ sin β_b) e_z`
//!
//! lies in the plane that touches the base cylinder at χ and the flank along the whole generating
//! line. A point with radius ρ, angle θ (from +y, counterclockwise) and height z has T = √(ρ² −
//! r_b²) and χ = θ − σ arctan(T/r_b); against the place where the nominal flank has that T and z it
//! is turned by
//!
//! `Δχ = θ − s(ψ + τ inv α_t) − turn·z + σ (ξ − arctan ξ)`, ξ = T/r_b, and
//!
//! `δ = s r_b cos β_b Δχ`, `L = T − τ δ cos β_b`, foot at `z + s h δ sin β_b`.
//!
//! Nothing is iterated and nothing neglected. Of the two planes through a point that touch the base
//! cylinder this is the one whose foot is nearest; a foot with L < 0 would lie before the
//! involute's start, where there is no flank.

use std::f64::consts::TAU;

use crate::{Gear, Side, involute::Flank, involute::inv_of_roll};
use flankfit_geometry::space::Vector;
use flankfit_numerics::words::Shown;

/// Foot of a point on a gear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// 1 is the tooth at the top; numbers go clockwise as the viewer sees them, up to z.
    pub tooth: u32,
    /// Flank of the tooth.
    pub side: Side,
    /// mm; never negative.
    pub roll_length: f64,
    /// mm.
    pub z: f64,
    /// Along the normal of the unmodified flank, mm; positive out of the material.
    pub distance: f64,
}

/// Why a point has no foot.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoFoot {
    /// The point lies inside the base circle, where the flank has no normals.
    #[error("the point lies inside the base circle (diameter {} mm, base circle {} mm), where the flank has no normals",
        short(2.0 * radius), short(2.0 * base_radius))]
    InsideBase {
        /// Distance of the point from the axis, mm.
        radius: f64,
        /// Radius of the base circle, mm.
        base_radius: f64,
    },
    /// The foot would lie before the start of the involute.
    #[error("its foot would lie {} mm of roll before the start of the involute on the base circle",
        short(-roll_length))]
    BeforeInvolute {
        /// Roll length that the foot would have, mm, below 0.
        roll_length: f64,
    },
    /// The point is farther from the nearest flank than a deviation may be.
    #[error("the point lies {} mm from the {} flank of tooth {tooth}, farther than {} mm: it is on another flank or \
        another gear",
        short(*distance), word(*side), short(*reach))]
    Far {
        /// Distance along the normal, mm.
        distance: f64,
        /// Distance allowed, mm.
        reach: f64,
        /// Tooth of that flank, from 1.
        tooth: u32,
        /// Side of that flank.
        side: Side,
    },
    /// The foot lies outside the tip or root circle.
    #[error("its foot has diameter {} mm and lies outside the {} circle of {} mm by more than {} mm", short(*diameter),
        if *tip { "tip" } else { "root" }, short(*circle), short(*reach))]
    OffTooth {
        /// Diameter of the foot, mm.
        diameter: f64,
        /// Diameter of the circle, mm.
        circle: f64,
        /// True for the tip circle; else it is the root circle.
        tip: bool,
        /// Distance outside it that a foot may have, mm.
        reach: f64,
    },
    /// The normal given with the point points into the material.
    #[error("the normal given with the point points into the material of the {} flank of tooth {tooth}", word(*side))]
    Against {
        /// Tooth of that flank, from 1.
        tooth: u32,
        /// Side of that flank.
        side: Side,
    },
    /// The modification is not defined at the foot.
    #[error("the modification has no value at its foot (roll length {} mm, z {} mm)", short(*roll_length), short(*z))]
    NoRelief {
        /// Roll length of the foot, mm.
        roll_length: f64,
        /// Place of the foot on the face width, mm.
        z: f64,
    },
}

/// To a tenth of a micrometre, as messages say it.
fn short(length: f64) -> Shown {
    let rounded = (length * 1e4).round() / 1e4;
    Shown(if rounded.is_finite() { rounded } else { length })
}

/// As messages call it.
pub(crate) fn word(side: Side) -> &'static str {
    match side {
        Side::Left => "left",
        Side::Right => "right",
    }
}

/// Angle from one tooth to the next, rad.
fn pitch_angle(gear: &Gear) -> f64 {
    TAU / gear.teeth()
}

/// How far a tooth (from 1) is turned against the one at the top, rad counterclockwise.
pub fn tooth_angle(gear: &Gear, tooth: u32) -> f64 {
    (1.0 - f64::from(tooth)) * pitch_angle(gear)
}

/// The vector turned about z, counterclockwise.
pub fn turned(vector: Vector, angle: f64) -> Vector {
    let (sin, cos) = angle.sin_cos();
    Vector::new(cos * vector.x - sin * vector.y, sin * vector.x + cos * vector.y, vector.z)
}

/// By how much the flank `side` of the tooth at the top is turned against one through the centre of
/// the ball, rad counterclockwise, from anywhere; with the roll length of the point itself. `None`
/// inside the base circle.
fn turn_of(gear: &Gear, side: Side, centre: &Vector) -> Option<[f64; 2]> {
    let (base, outward) = (gear.base_radius(), gear.outward());
    let radius = centre.x.hypot(centre.y);
    if !(radius >= base) {
        return None;
    }
    let tangent = ((radius - base) * (radius + base)).sqrt();
    let angle = (-centre.x).atan2(centre.y);
    let start = Flank::new(gear, side).start_angle();
    let turn = angle - start - gear.turn_per_length() * centre.z + side.sign() * outward * inv_of_roll(tangent / base);
    Some([turn, tangent])
}

/// By how much the gear must be turned, rad counterclockwise, for the flank `side` to touch a ball
/// there: of `tooth` within half a turn, of any tooth (`None`) within half a pitch. `None` inside
/// the base circle.
pub fn phase(gear: &Gear, side: Side, tooth: Option<u32>, centre: &Vector, ball: f64) -> Option<f64> {
    let [turn, _] = turn_of(gear, side, centre)?;
    let turn = turn - ball / (side.sign() * gear.base_radius() * gear.base_helix_angle().cos());
    let (turn, period) = match tooth {
        Some(tooth) => (turn + (f64::from(tooth) - 1.0) * pitch_angle(gear), TAU),
        None => (turn, pitch_angle(gear)),
    };
    Some(turn - period * (turn / period).round())
}

/// The foot of `centre` on the flank `side` of `tooth` (`None`: of the nearest tooth), the distance
/// being that of the ball of radius `ball` (0 for a point). Coordinates must be finite.
pub fn foot(gear: &Gear, side: Side, tooth: Option<u32>, centre: &Vector, ball: f64) -> Result<Foot, NoFoot> {
    let (base, s, outward) = (gear.base_radius(), side.sign(), gear.outward());
    let (sin_b, cos_b) = gear.base_helix_angle().sin_cos();
    let Some([turn, tangent]) = turn_of(gear, side, centre) else {
        return Err(NoFoot::InsideBase { radius: centre.x.hypot(centre.y), base_radius: base });
    };
    let per_angle = s * base * cos_b;
    let pitch = pitch_angle(gear);
    let count = gear.teeth();
    let index = match tooth {
        Some(tooth) => f64::from(tooth) - 1.0,
        None => ((ball / per_angle - turn) / pitch).round().rem_euclid(count),
    };
    // what is left of whole turns
    let turn = turn + index * pitch;
    let expected = ball / per_angle;
    let turn = turn - TAU * ((turn - expected) / TAU).round();
    let distance = per_angle * turn;
    let roll_length = tangent - outward * distance * cos_b;
    if !(roll_length >= 0.0) {
        return Err(NoFoot::BeforeInvolute { roll_length });
    }
    Ok(Foot {
        tooth: index as u32 + 1,
        side,
        roll_length,
        z: centre.z + s * gear.hand() * distance * sin_b,
        distance: distance - ball,
    })
}

/// The normal out of the material at a place of a tooth.
pub fn normal(gear: &Gear, tooth: u32, side: Side, roll_length: f64, z: f64) -> Vector {
    turned(Flank::new(gear, side).at(roll_length, z).normal, tooth_angle(gear, tooth))
}

/// The point (the ball's centre) at `distance` mm above a place of the flank.
pub fn above(gear: &Gear, tooth: u32, side: Side, roll_length: f64, z: f64, distance: f64) -> Vector {
    let place = Flank::new(gear, side).at(roll_length, z);
    turned(place.point + place.normal * distance, tooth_angle(gear, tooth))
}
