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

/// The part of the flank that is involute and really there, from the root form diameter to the tip
/// form diameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Usable {
    /// Root end first, on internal gears the greater one. mm.
    pub diameters: [f64; 2],
    /// Roll lengths there, mm.
    pub roll_lengths: [f64; 2],
}

/// Derived quantities. Lengths mm, angles rad.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// d = m_t z.
    pub reference_diameter: f64,
    /// d_b = d cos α_t.
    pub base_diameter: f64,
    /// Diameter of the shifted reference circle, d ± 2 x m_n.
    pub shifted_diameter: f64,
    /// As given, or with an addendum of (1 + x) m_n.
    pub tip_diameter: f64,
    /// As given, or as the tool's addendum says.
    pub root_diameter: f64,
    /// What the rack tool cuts; `None` where the root is not the work of a rack.
    pub generated_root_diameter: Option<f64>,
    /// Where the involute really starts at the root: the end of fillet or undercut.
    pub root_form_diameter: f64,
    /// Where it ends: the tip, the point of a pointed tooth, or the base circle if an internal
    /// tooth reaches below it.
    pub tip_form_diameter: f64,
    /// Where the flanks of a tooth meet. `None` on internal gears whose flanks do not.
    pub pointed_diameter: Option<f64>,
    /// Roll length at the root form diameter.
    pub roll_length_root_form: f64,
    /// Roll length at the tip form diameter.
    pub roll_length_tip_form: f64,
    /// `None` where the involute would start beyond the tip.
    pub usable: Option<Usable>,
    /// m_t = m_n / cos β.
    pub transverse_module: f64,
    /// α_t, of tan α_t = tan α_n / cos β.
    pub transverse_pressure_angle: f64,
    /// β_b, of sin β_b = sin β cos α_n.
    pub base_helix_angle: f64,
    /// inv α_t.
    pub involute: f64,
    /// p_t = π m_t.
    pub transverse_pitch: f64,
    /// p_n = π m_n.
    pub normal_pitch: f64,
    /// π m_n / sin β; `None` on spur gears.
    pub axial_pitch: Option<f64>,
    /// Height of one turn of the helix; `None` on spur gears.
    pub lead: Option<f64>,
    /// p_bt = p_t cos α_t.
    pub transverse_base_pitch: f64,
    /// p_bn = p_n cos α_n.
    pub normal_base_pitch: f64,
    /// On the reference cylinder.
    pub tooth_thickness: Arc,
    /// On the reference cylinder.
    pub space_width: Arc,
    /// On the tip cylinder; 0 where the tooth is pointed.
    pub tip_thickness: Arc,
    /// On the base cylinder, transverse, where the flanks' involutes start.
    pub base_thickness: f64,
    /// ψ.
    pub half_tooth_angle: f64,
    /// From the root circle that is really there to the tip.
    pub tooth_depth: f64,
    /// z / (cos² β_b cos β).
    pub virtual_teeth: f64,
    /// The smallest x without undercut by the tool; `None` where the root is not the work of a
    /// rack.
    pub least_profile_shift: Option<f64>,
    /// Whether the tool's tip cuts into the involute.
    pub undercut: bool,
    /// `None` where no measure over teeth (internal: spaces) is possible.
    pub span: Option<Span>,
    /// `None` where no ball touches both flanks.
    pub balls: Option<Balls>,
    /// What is unusual about the gear.
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

/// Thickness of a tooth on the cylinder of a roll length; 0 beyond a tooth's point.
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
    /// assert_eq!((geometry.reference_diameter, geometry.tip_diameter), (40.0, 44.0));
    /// assert!((geometry.tooth_thickness.transverse - std::f64::consts::PI).abs() < 1e-12);
    /// assert!((geometry.space_width.transverse - std::f64::consts::PI).abs() < 1e-12);
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
            diameters: [gear.diameter(root_roll), gear.diameter(tip_roll)],
            roll_lengths: [root_roll, tip_roll],
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
        let mut geometry = Geometry {
            reference_diameter: reference,
            base_diameter: 2.0 * gear.base_radius(),
            shifted_diameter: reference + 2.0 * out * data.profile_shift * data.normal_module,
            tip_diameter: tip,
            root_diameter: 2.0 * gear.root_radius(),
            generated_root_diameter: root.rack().map(|fillet| 2.0 * fillet.root_radius()),
            root_form_diameter: gear.diameter(root_roll),
            tip_form_diameter: gear.diameter(tip_roll),
            pointed_diameter: pointed,
            roll_length_root_form: root_roll,
            roll_length_tip_form: tip_roll,
            usable,
            transverse_module: gear.transverse_module(),
            transverse_pressure_angle: gear.transverse_pressure_angle(),
            base_helix_angle: gear.base_helix_angle(),
            involute: inv_of_roll(gear.transverse_pressure_angle().tan()),
            transverse_pitch: pitch,
            normal_pitch: PI * data.normal_module,
            axial_pitch: helical
                .then(|| PI * data.normal_module / data.helix_angle.sin())
                .filter(|pitch| pitch.is_finite()),
            lead: helical.then(|| PI * reference / data.helix_angle.tan()),
            transverse_base_pitch: gear.base_pitch(),
            normal_base_pitch: PI * data.normal_module * data.pressure_angle.cos(),
            tooth_thickness: arc(gear, reference, thickness),
            space_width: arc(gear, reference, pitch - thickness),
            tip_thickness,
            base_thickness: 2.0 * gear.base_radius() * flank.half_angle(0.0).max(0.0),
            half_tooth_angle: gear.half_tooth_angle(),
            tooth_depth: out * (gear.tip_radius() - root.root_radius(gear)),
            virtual_teeth: gear.teeth() / (gear.base_helix_angle().cos().powi(2) * data.helix_angle.cos()),
            least_profile_shift: root.rack().map(|fillet| fillet.least_shift(gear)),
            undercut: root.rack().is_some_and(|fillet| fillet.undercut()),
            span: Span::recommended(gear, usable.as_ref()),
            balls: Balls::recommended(gear, usable.as_ref()),
            warnings: Vec::new(),
        };
        geometry.warnings = warning::of(gear, &root, &geometry);
        geometry
    }
}
