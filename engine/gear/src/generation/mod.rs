//! Generation of the tooth root by the tool, and the transverse profile of a whole tooth.
//!
//! Transverse sections are described in polar form, in the tooth's own frame: a radius and the
//! angle from the tooth's middle, which is the same for both flanks. An external gear is generated
//! by a rack ([`rack`]): the straight flank leaves the involute, its tip rounding the fillet. A
//! rack cannot reach into an internal gear, and the data of a pinion-type cutter are not a part of
//! the gear's; there the root is an arc that touches both the involute and the root circle
//! ([`arc`]). What any other tool leaves, rack or pinion-type, is computed from points of its
//! profile ([`envelope`]).

pub mod arc;
pub mod envelope;
pub mod rack;
pub mod root;
mod tool_profile;
pub mod tooth;

pub use root::Root;

/// A point of a transverse section, about the middle of its tooth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polar {
    /// mm.
    pub radius: f64,
    /// From the tooth's middle towards its left flank (and, mirrored, its right one), rad.
    pub half_angle: f64,
}

impl Polar {
    /// Returns the point given by (x, y), where the tooth's middle is the y axis.
    fn of(x: f64, y: f64) -> Self {
        Polar { radius: x.hypot(y), half_angle: (-x).atan2(y) }
    }

    /// (x, y) on the left flank (`sign` 1) or the right one (−1) of a tooth whose middle is at
    /// `turn`, rad counterclockwise from +y.
    pub fn point(self, sign: f64, turn: f64) -> [f64; 2] {
        let (sin, cos) = (sign * self.half_angle + turn).sin_cos();
        [-self.radius * sin, self.radius * cos]
    }
}
