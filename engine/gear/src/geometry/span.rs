//! Span measurement: the distance of two parallel planes over k teeth (internal spur gears: over k
//! spaces).
//!
//! `W_k = m_n cos α_n ((k − 1/2) π + z inv α_t) ± 2 x m_n sin α_n`, + on external and − on internal
//! gears (ISO 21771). The line of measurement is a common normal of both flanks and touches the
//! base cylinder; it meets the flanks at the roll length W_k cos β_b / 2.

use std::f64::consts::PI;

use super::Usable;
use crate::{Gear, involute::inv_of_roll};

/// Tooth counts on either side of the best one that are tried.
const NEIGHBOURS: u32 = 3;

/// Span measurement over k teeth (internal spur gears: spaces).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, utoipa::ToSchema), schema(as = SpanMeasurement))]
pub struct Span {
    /// k, the number of teeth (of internal gears: spaces) that are spanned.
    pub teeth: u32,
    /// W_k.
    pub length_mm: f64,
    /// Diameter on which the measuring faces touch the flanks.
    pub contact_diameter_mm: f64,
    /// Least face width with which a helical gear can be measured so: W_k sin β_b.
    pub least_face_width_mm: f64,
    /// True if it can be measured: the contact lies on the usable flank, and the face, if its width
    /// is known, is wide enough.
    pub feasible: bool,
}

impl Span {
    /// The span over `teeth` teeth; `None` on internal helical gears, whose flanks two planes
    /// cannot touch, and where no length is left.
    ///
    /// ```
    /// use flankfit_gear::{Gear, GearData, geometry::span::Span};
    ///
    /// // W₃ of 20 teeth, module 1: tables give 7.6604 mm.
    /// let gear = Gear::new(GearData::spur(20, 1.0))?;
    /// let span = Span::over(&gear, 3, None).unwrap();
    /// assert!((span.length_mm - 7.6604).abs() < 5e-5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn over(gear: &Gear, teeth: u32, usable: Option<&Usable>) -> Option<Self> {
        let data = gear.data();
        if teeth == 0 || teeth > data.teeth || (data.internal && data.helix_angle > 0.0) {
            return None;
        }
        let (sin, cos) = data.pressure_angle.sin_cos();
        let involute = inv_of_roll(gear.transverse_pressure_angle().tan());
        let length = data.normal_module * cos * ((f64::from(teeth) - 0.5) * PI + gear.teeth() * involute)
            + gear.outward() * 2.0 * data.profile_shift * data.normal_module * sin;
        let contact_diameter = gear.diameter(0.5 * length * gear.base_helix_angle().cos());
        let least_face_width = length * gear.base_helix_angle().sin();
        let touches = usable.is_some_and(|usable| {
            let [a, b] = usable.diameters_mm;
            a.min(b) <= contact_diameter && contact_diameter <= a.max(b)
        });
        let wide = data.face_width.is_none_or(|width| width > least_face_width);
        (length > 0.0).then_some(Span {
            teeth,
            length_mm: length,
            contact_diameter_mm: contact_diameter,
            least_face_width_mm: least_face_width,
            feasible: touches && wide,
        })
    }

    /// The span that touches nearest to the shifted reference circle, with neighbouring numbers of
    /// teeth where it is not feasible.
    pub fn recommended(gear: &Gear, usable: Option<&Usable>) -> Option<Self> {
        let data = gear.data();
        let shifted = gear.reference_radius() + gear.outward() * data.profile_shift * data.normal_module;
        let between = usable.map(|usable| 0.5 * (usable.roll_lengths_mm[0] + usable.roll_lengths_mm[1]));
        let wanted = gear.roll_length(2.0 * shifted).filter(|roll| *roll > 0.0).or(between)?;
        let one = Span::over(gear, 1, usable)?.length_mm;
        let step = PI * data.normal_module * data.pressure_angle.cos();
        let best = (1.0 + (2.0 * wanted / gear.base_helix_angle().cos() - one) / step).round();
        let best = best.clamp(1.0, gear.teeth()) as u32;
        let near = |k: u32| Span::over(gear, k, usable);
        (0..=NEIGHBOURS)
            .flat_map(|n| [best + n, best.saturating_sub(n)])
            .filter_map(near)
            .find(|span| span.feasible)
            .or_else(|| near(best))
    }
}
