//! The root of an internal gear: an arc that touches the involute and the root circle.
//!
//! A rack cannot generate it, so what a pinion-type cutter leaves is replaced by a circle of the
//! tool's tip radius ρ in the transverse section. Its centre lies on the generating line of the
//! point of contact, ρ nearer to the base tangent point, and ρ inside the root circle: `(L − ρ)² +
//! r_b² = (r_f − ρ)²`.

use super::Polar;
use crate::{Gear, Side, involute::Flank};
use flankfit_numerics::root::boundary;

/// Arc between involute and root circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RootArc {
    /// mm; smaller than asked where the space takes no more.
    pub radius: f64,
    /// Roll length where involute and arc meet, mm.
    pub form_roll: f64,
    centre: Polar,
    /// Angle of the direction from the centre to the involute, as that to the root circle is the
    /// centre's own.
    touching: f64,
}

impl RootArc {
    /// The arc of radius `asked`, or the one that fills the space's whole ground where that is
    /// smaller.
    pub fn new(gear: &Gear, asked: f64) -> Self {
        let middle = 0.5 * gear.pitch_angle();
        let fits = |radius: f64| Self::of(gear, radius).is_some_and(|arc| arc.centre.half_angle <= middle);
        let radius = if fits(asked) { asked } else { boundary([0.0, asked], 0.0, fits)[0] };
        Self::of(gear, radius).unwrap_or_else(|| Self::corner(gear))
    }

    fn of(gear: &Gear, radius: f64) -> Option<Self> {
        let centre_radius = gear.root_radius() - radius;
        let centre_roll = gear.roll_length(2.0 * centre_radius).filter(|_| centre_radius > 0.0)?;
        let form_roll = centre_roll + radius;
        let tangent = Flank::new(gear, Side::Left).tangent_angle(form_roll, 0.0);
        let half_angle = tangent - (centre_roll / gear.base_radius()).atan();
        Some(RootArc {
            radius,
            form_roll,
            centre: Polar { radius: centre_radius, half_angle },
            touching: tangent - std::f64::consts::FRAC_PI_2,
        })
    }

    /// Involute and root circle meet in a corner.
    fn corner(gear: &Gear) -> Self {
        let form_roll = gear.roll_length(2.0 * gear.root_radius()).unwrap_or(0.0);
        let half_angle = Flank::new(gear, Side::Left).half_angle(form_roll);
        let centre = Polar { radius: gear.root_radius(), half_angle };
        RootArc { radius: 0.0, form_roll, centre, touching: half_angle }
    }

    /// `count` + 1 points from the root circle to where the involute starts.
    pub fn points(&self, count: usize) -> Vec<Polar> {
        let [x, y] = self.centre.point(1.0, 0.0);
        let start = self.centre.half_angle;
        let point = |k: usize| {
            let (sin, cos) = (start + (self.touching - start) * k as f64 / count.max(1) as f64).sin_cos();
            Polar::of(x - self.radius * sin, y + self.radius * cos)
        };
        (0..=count).map(point).collect()
    }
}
