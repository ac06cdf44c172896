//! Dimension over (internal: between) two balls in opposite spaces.
//!
//! A ball of diameter D that touches both flanks of a space has its centre on involutes that are
//! displaced by D/2 along the normal: `inv α_Kt = inv α_t ± (D / (d_b cos β_b) − π/z + ψ)`, + on
//! external and − on internal gears, and d_K = d_b / cos α_Kt. With an odd number of teeth the
//! spaces are half a pitch off opposite: `M = d_K cos(π/2z) ± D`. (Pins on helical gears with odd z
//! touch along their length and measure d_K ± D instead.)

use std::f64::consts::PI;

use super::Usable;
use crate::{
    Gear,
    involute::{inv_of_roll, roll_of_inv},
};
use flankfit_numerics::root::boundary;

/// Dimension over two balls, between them on internal gears.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, utoipa::ToSchema), schema(as = DimensionOverBalls))]
pub struct Balls {
    /// D, diameter of the balls.
    pub ball_diameter_mm: f64,
    /// M_dK: over two balls in opposite spaces (of an odd number of teeth in those nearest to
    /// opposite).
    pub dimension_mm: f64,
    /// Diameter of the circle on which the centres of the balls lie.
    pub centre_diameter_mm: f64,
    /// Diameter on which the balls touch the flanks.
    pub contact_diameter_mm: f64,
    /// True if the balls touch on the usable flank and protrude from the teeth.
    pub feasible: bool,
}

/// inv α_Kt of balls of diameter `ball`.
fn centre_involute(gear: &Gear, ball: f64) -> f64 {
    let into = ball / (2.0 * gear.base_radius() * gear.base_helix_angle().cos());
    let half_space = 0.5 * gear.pitch_angle() - gear.half_tooth_angle();
    inv_of_roll(gear.transverse_pressure_angle().tan()) + gear.outward() * (into - half_space)
}

impl Balls {
    /// The measure with balls of diameter `ball` mm; `None` where they touch no involute.
    ///
    /// ```
    /// use flankfit_gear::{Gear, GearData, geometry::balls::Balls};
    ///
    /// // With an even number of teeth the balls lie opposite each other.
    /// let gear = Gear::new(GearData::spur(20, 1.0))?;
    /// let balls = Balls::with(&gear, 1.75, None).unwrap();
    /// assert!((balls.dimension_mm - (balls.centre_diameter_mm + 1.75)).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with(gear: &Gear, ball: f64, usable: Option<&Usable>) -> Option<Self> {
        let (out, odd) = (gear.outward(), gear.data().teeth % 2 == 1);
        let involute = centre_involute(gear, ball);
        let roll = (involute >= 0.0).then(|| gear.base_radius() * roll_of_inv(involute))?;
        let contact = roll - out * 0.5 * ball * gear.base_helix_angle().cos();
        let centre = gear.diameter(roll);
        let apart = if odd { (0.5 * PI / gear.teeth()).cos() } else { 1.0 };
        let contact_diameter = (contact >= 0.0).then(|| gear.diameter(contact))?;
        let touches = usable.is_some_and(|usable| {
            let [a, b] = usable.roll_lengths_mm;
            a.min(b) <= contact && contact <= a.max(b)
        });
        let protrudes = out * (centre + out * ball - 2.0 * gear.tip_radius()) > 0.0;
        Some(Balls {
            ball_diameter_mm: ball,
            dimension_mm: centre * apart + out * ball,
            centre_diameter_mm: centre,
            contact_diameter_mm: contact_diameter,
            feasible: touches && protrudes,
        })
    }

    /// The ball that touches on the shifted reference circle, its diameter rounded to two digits.
    pub fn recommended(gear: &Gear, usable: Option<&Usable>) -> Option<Self> {
        let data = gear.data();
        let shifted = gear.reference_radius() + gear.outward() * data.profile_shift * data.normal_module;
        let between = usable.map(|usable| 0.5 * (usable.roll_lengths_mm[0] + usable.roll_lengths_mm[1]));
        let wanted = gear.roll_length(2.0 * shifted).filter(|roll| *roll > 0.0).or(between)?;
        let half = 0.5 * gear.base_helix_angle().cos();
        // Positive as long as the ball is too small; falls with the diameter.
        let room = |ball: f64| {
            let roll = (wanted + gear.outward() * half * ball) / gear.base_radius();
            gear.outward() * (inv_of_roll(roll) - centre_involute(gear, ball))
        };
        if !(room(0.0) > 0.0) {
            return None;
        }
        let (mut low, mut high) = (0.0, data.normal_module);
        for _ in 0..40 {
            if room(high) < 0.0 {
                break;
            }
            (low, high) = (high, 2.0 * high);
        }
        let [_, high] = boundary([low, high], 0.0, |ball| room(ball) > 0.0);
        let digits = 1.0 - high.log10().floor();
        let round = if digits >= 0.0 {
            let per = 10f64.powf(digits);
            (high * per).round() / per
        } else {
            high.round()
        };
        Balls::with(gear, round, usable).or_else(|| Balls::with(gear, high, usable))
    }
}
