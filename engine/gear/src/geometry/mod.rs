//! Derived quantities of a gear (ISO 21771): diameters, thicknesses, the part of the flank that is
//! involute, measures, warnings.
//!
//! Nothing is left out silently: a quantity that a gear has not got (the lead of a spur gear, the
//! span of an internal helical one) is `None`. All diameters and thicknesses are positive, on
//! internal gears too.

pub mod balls;
pub mod span;
pub mod warning;

pub use balls::Balls;
pub use span::Span;
pub use warning::Warning;

use std::f64::consts::PI;

use super::{
    Gear, Side,
    generation::Root,
    involute::{Flank, inv_of_roll, roll_of_inv},
};

/// A thickness on a cylinder as an arc in the transverse section, and across the tooth's helix
/// there. mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// Arc in the transverse section.
    pub transverse: f64,
    /// Across the helix.
    pub normal: f64,
}

/// The part of the flank that is involute and not cut off, its root end first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, utoipa::ToSchema), schema(as = UsableProfile))]
pub struct Usable {
    /// `[root end, tip end]`.
    pub diameters_mm: [f64; 2],
    /// The same as roll lengths.
    pub roll_lengths_mm: [f64; 2],
}

/// Derived quantities (ISO 21771). Diameters and thicknesses are positive, on internal gears too; a
/// quantity that a gear does not have is absent.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, utoipa::ToSchema),
    schema(as = GearGeometry)
)]
pub struct Geometry {
    /// d = z m_n / cos β.
    pub reference_diameter_mm: f64,
    /// d_b = d cos α_t.
    pub base_diameter_mm: f64,
    /// d ± 2 x m_n.
    pub shifted_diameter_mm: f64,
    /// As given, or with an addendum of (1 + x) m_n.
    pub tip_diameter_mm: f64,
    /// As given, or from the tool's addendum.
    pub root_diameter_mm: f64,
    /// Root diameter that the rack tool cuts; absent if no rack cuts the root.
    pub generated_root_diameter_mm: Option<f64>,
    /// Diameter at which the involute starts: the end of fillet or undercut.
    pub form_diameter_mm: f64,
    /// Diameter at which the involute ends: the tip, the point of a pointed tooth, or the base
    /// circle if an internal tooth reaches below it.
    pub tip_form_diameter_mm: f64,
    /// Diameter at which the flanks of a tooth would meet; absent on internal gears whose flanks do
    /// not.
    pub pointed_diameter_mm: Option<f64>,
    /// Roll length at the form diameter, where the involute ends towards the root.
    pub form_roll_length_mm: f64,
    /// Roll length at the tip form diameter, where the involute ends towards the tip.
    pub tip_form_roll_length_mm: f64,
    /// The part of the flank that is involute and not cut off; absent if there is none.
    pub usable_profile: Option<Usable>,
    /// m_t = m_n / cos β.
    pub transverse_module_mm: f64,
    /// α_t, at the reference diameter.
    pub transverse_pressure_angle_deg: f64,
    /// β_b, never negative; the hand is that of the gear.
    pub base_helix_angle_deg: f64,
    /// inv α_t = tan α_t − α_t, rad.
    pub involute: f64,
    /// p_t, on the reference circle.
    pub transverse_pitch_mm: f64,
    /// p_n = π m_n.
    pub normal_pitch_mm: f64,
    /// p_x = π m_n / sin β; absent for spur gears, which have none.
    pub axial_pitch_mm: Option<f64>,
    /// Height of one turn of the helix; absent for spur gears.
    pub lead_mm: Option<f64>,
    /// p_bt, on the base circle.
    pub transverse_base_pitch_mm: f64,
    /// p_bn, at right angles to the flanks.
    pub normal_base_pitch_mm: f64,
    /// Tooth thickness on the reference circle, in the transverse section.
    pub tooth_thickness_mm: f64,
    /// Tooth thickness on the reference cylinder, across the helix.
    pub normal_tooth_thickness_mm: f64,
    /// Transverse width of a tooth space on the reference circle.
    pub space_width_mm: f64,
    /// Normal width of a tooth space on the reference cylinder.
    pub normal_space_width_mm: f64,
    /// Transverse thickness of a tooth at its tip; 0 if the tooth is pointed.
    pub tip_thickness_mm: f64,
    /// Normal thickness of a tooth at its tip.
    pub normal_tip_thickness_mm: f64,
    /// Transverse thickness of a tooth on the base circle.
    pub base_thickness_mm: f64,
    /// ψ, on the reference circle.
    pub half_tooth_angle_deg: f64,
    /// h, half the difference of tip and root diameter.
    pub tooth_depth_mm: f64,
    /// z_n = z / (cos² β_b cos β), teeth of the spur gear that a helical gear resembles in its
    /// normal section.
    pub virtual_teeth: f64,
    /// The smallest profile shift without undercut by the rack tool; absent if no rack cuts the
    /// root.
    pub least_profile_shift_coefficient: Option<f64>,
    /// True if the tool cuts into the involute near the root.
    pub undercut: bool,
    /// Span measurement; absent if none is possible.
    pub span: Option<Span>,
    /// Dimension over balls; absent if no ball touches both flanks.
    pub balls: Option<Balls>,
    /// Warnings.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub warnings: Vec<Warning>,
}

/// The diameter at which the flanks of a tooth meet.
pub fn pointed_diameter(gear: &Gear) -> Option<f64> {
    let flank = Flank::new(gear, Side::Left);
    // External: inv ξ = ψ + inv α_t. Internal: the tooth grows outwards, and its flanks meet where
    // inv ξ = inv α_t − ψ.
    let start = gear.outward() * flank.half_angle(0.0);
    (start >= 0.0).then(|| gear.diameter(gear.base_radius() * roll_of_inv(start)))
}

/// Thickness of a tooth on the cylinder of a roll length; 0 above a tooth's point.
pub fn tooth_thickness(gear: &Gear, roll_length: f64) -> Arc {
    let half_angle = Flank::new(gear, Side::Left).half_angle(roll_length).max(0.0);
    let diameter = gear.diameter(roll_length);
    arc(gear, diameter, half_angle * diameter)
}

fn arc(gear: &Gear, diameter: f64, transverse: f64) -> Arc {
    let tan_helix = gear.base_helix_angle().tan() * 0.5 * diameter / gear.base_radius();
    Arc { transverse, normal: transverse / 1f64.hypot(tan_helix) }
}

impl Geometry {
    /// Everything about `gear`.
    ///
    /// ```
    /// use flankfit_gear::{Gear, GearData, Geometry};
    ///
    /// // Module 2, 20 teeth, no shift: d = 40, d_a = 44, pitch 2π, tooth and space π each.
    /// let geometry = Geometry::of(&Gear::new(GearData::spur(20, 2.0))?);
    /// assert_eq!((geometry.reference_diameter_mm, geometry.tip_diameter_mm), (40.0, 44.0));
    /// assert!((geometry.tooth_thickness_mm - std::f64::consts::PI).abs() < 1e-12);
    /// assert!((geometry.space_width_mm - std::f64::consts::PI).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(gear: &Gear) -> Self {
        let data = gear.data();
        let root = Root::of(gear);
        let flank = Flank::new(gear, Side::Left);
        let (reference, out) = (2.0 * gear.reference_radius(), gear.outward());
        let pointed = pointed_diameter(gear);
        let tip = 2.0 * gear.tip_radius();
        // Between the point of a pointed tooth and its nominal tip there is nothing.
        let reached = pointed.map_or(tip, |pointed| if data.internal { tip.max(pointed) } else { tip.min(pointed) });
        let tip_roll = gear.roll_length(reached).unwrap_or(0.0);
        let root_roll = root.form_roll();
        let usable = (out * (tip_roll - root_roll) > 0.0).then(|| Usable {
            diameters_mm: [gear.diameter(root_roll), gear.diameter(tip_roll)],
            roll_lengths_mm: [root_roll, tip_roll],
        });
        let tip_thickness = match gear.roll_length(tip) {
            Some(roll) => tooth_thickness(gear, roll),
            // An internal tooth below the base circle keeps the angle it has there, between radial
            // sides.
            None => arc(gear, tip, tip * flank.half_angle(0.0).max(0.0)),
        };
        let pitch = PI * gear.transverse_module();
        let thickness = reference * gear.half_tooth_angle();
        let helical = data.helix_angle > 0.0;
        let [tooth, space] = [thickness, pitch - thickness].map(|width| arc(gear, reference, width));
        let mut geometry = Geometry {
            reference_diameter_mm: reference,
            base_diameter_mm: 2.0 * gear.base_radius(),
            shifted_diameter_mm: reference + 2.0 * out * data.profile_shift * data.normal_module,
            tip_diameter_mm: tip,
            root_diameter_mm: 2.0 * gear.root_radius(),
            generated_root_diameter_mm: root.rack().map(|fillet| 2.0 * fillet.root_radius()),
            form_diameter_mm: gear.diameter(root_roll),
            tip_form_diameter_mm: gear.diameter(tip_roll),
            pointed_diameter_mm: pointed,
            form_roll_length_mm: root_roll,
            tip_form_roll_length_mm: tip_roll,
            usable_profile: usable,
            transverse_module_mm: gear.transverse_module(),
            transverse_pressure_angle_deg: gear.transverse_pressure_angle().to_degrees(),
            base_helix_angle_deg: gear.base_helix_angle().to_degrees(),
            involute: inv_of_roll(gear.transverse_pressure_angle().tan()),
            transverse_pitch_mm: pitch,
            normal_pitch_mm: PI * data.normal_module,
            axial_pitch_mm: helical
                .then(|| PI * data.normal_module / data.helix_angle.sin())
                .filter(|pitch| pitch.is_finite()),
            lead_mm: helical.then(|| PI * reference / data.helix_angle.tan()),
            transverse_base_pitch_mm: gear.base_pitch(),
            normal_base_pitch_mm: PI * data.normal_module * data.pressure_angle.cos(),
            tooth_thickness_mm: tooth.transverse,
            normal_tooth_thickness_mm: tooth.normal,
            space_width_mm: space.transverse,
            normal_space_width_mm: space.normal,
            tip_thickness_mm: tip_thickness.transverse,
            normal_tip_thickness_mm: tip_thickness.normal,
            base_thickness_mm: 2.0 * gear.base_radius() * flank.half_angle(0.0).max(0.0),
            half_tooth_angle_deg: gear.half_tooth_angle().to_degrees(),
            tooth_depth_mm: out * (gear.tip_radius() - root.root_radius(gear)),
            virtual_teeth: gear.teeth() / (gear.base_helix_angle().cos().powi(2) * data.helix_angle.cos()),
            least_profile_shift_coefficient: root.rack().map(|fillet| fillet.least_shift(gear)),
            undercut: root.rack().is_some_and(|fillet| fillet.undercut()),
            span: Span::recommended(gear, usable.as_ref()),
            balls: Balls::recommended(gear, usable.as_ref()),
            warnings: Vec::new(),
        };
        geometry.warnings = warning::of(gear, &root, &geometry);
        geometry
    }
}
