//! A gear's data, checked once, with what ISO 21771 derives from them.

use std::f64::consts::{FRAC_PI_2, PI};

/// No length of a gear is smaller (but a radius of its tool), mm: a µm.
pub const LEAST_LENGTH: f64 = 1e-3;
/// No length is larger, mm: a kilometre.
pub const MOST_LENGTH: f64 = 1e6;
/// α_n, degrees; the upper end is outside.
pub const PRESSURE_ANGLES: [f64; 2] = [0.1, 80.0];
/// β, degrees; the upper end is outside.
pub const HELIX_ANGLES: [f64; 2] = [0.0, 89.0];
/// Tip diameter without data: this addendum (in modules) above the shifted reference circle.
pub const ADDENDUM: f64 = 1.0;
/// Dedendum without data, the addendum of the standard rack tool (ISO 53, profile A).
pub const DEDENDUM: f64 = 1.25;

/// Direction of the helix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = HandName)
)]
pub enum Hand {
    /// Like a common screw: the section turns counterclockwise on its way to the viewer.
    Right,
    /// The mirror image: the section turns clockwise on its way to the viewer.
    Left,
}

/// A flank of a tooth that points up, seen with the axis towards the viewer; on internal gears too,
/// where the tooth at the top points down and the left flank lies at negative x.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = FlankSide)
)]
pub enum Side {
    /// The flank on the viewer's left (−x).
    Left,
    /// The flank on the viewer's right (+x).
    Right,
}

impl Side {
    /// +1 for the left flank, which lies counterclockwise of its tooth; −1 for the right one.
    pub fn sign(self) -> f64 {
        match self {
            Side::Left => 1.0,
            Side::Right => -1.0,
        }
    }
}

/// The rack tool that generates the root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tool {
    /// mm.
    pub tip_radius: f64,
    /// Addendum h_aP0* in normal modules, from the datum line, on which tooth and space of the tool
    /// are equal.
    pub addendum_factor: f64,
    /// Distance by which the tip's rounding protrudes from the straight flank, mm along its normal.
    pub protuberance: f64,
}

/// Data of a gear as given. Lengths mm, angles rad.
#[derive(Clone, Debug, PartialEq)]
pub struct GearData {
    /// Number of teeth z, above 0 on internal gears too.
    pub teeth: u32,
    /// Normal module m_n.
    pub normal_module: f64,
    /// α_n.
    pub pressure_angle: f64,
    /// β ≥ 0 on the reference cylinder.
    pub helix_angle: f64,
    /// Direction of the helix; without meaning where β = 0.
    pub hand: Hand,
    /// x as in ISO 21771: positive towards the tip, on internal gears too, so that a positive x
    /// makes every tooth thicker.
    pub profile_shift: f64,
    /// Face width b; `None` where not known.
    pub face_width: Option<f64>,
    /// Tip diameter d_a; by default with an addendum of (1 + x) m_n.
    pub tip_diameter: Option<f64>,
    /// Root diameter d_f; by default as the tool's addendum says.
    pub root_diameter: Option<f64>,
    /// Whether the teeth point inwards.
    pub internal: bool,
    /// Tool that generates the root; by default a standard one is assumed.
    pub tool: Option<Tool>,
}

impl GearData {
    /// An external spur gear without profile shift, α_n = 20°; face width and diameters are left to
    /// the defaults.
    pub fn spur(teeth: u32, normal_module: f64) -> Self {
        GearData {
            teeth,
            normal_module,
            pressure_angle: 20_f64.to_radians(),
            helix_angle: 0.0,
            hand: Hand::Right,
            profile_shift: 0.0,
            face_width: None,
            tip_diameter: None,
            root_diameter: None,
            internal: false,
            tool: None,
        }
    }
}

/// A gear that can exist. All radii are positive, on internal gears too.
#[derive(Clone, Debug, PartialEq)]
pub struct Gear {
    data: GearData,
    transverse_pressure_angle: f64,
    base_radius: f64,
    base_helix_angle: f64,
    tip_radius: f64,
    root_radius: f64,
}

impl Gear {
    /// Returns what follows from data that have been checked.
    pub(super) fn derived(data: GearData) -> Self {
        let module = data.normal_module / data.helix_angle.cos();
        let reference = 0.5 * f64::from(data.teeth) * module;
        let transverse_pressure_angle = (data.pressure_angle.tan() / data.helix_angle.cos()).atan();
        let out = if data.internal { -1.0 } else { 1.0 };
        let shifted = data.normal_module * data.profile_shift;
        let dedendum = data.tool.map_or(DEDENDUM, |tool| tool.addendum_factor);
        let tip = data.tip_diameter.map_or(reference + out * (ADDENDUM * data.normal_module + shifted), |d| 0.5 * d);
        let root = data.root_diameter.map_or(reference - out * (dedendum * data.normal_module - shifted), |d| 0.5 * d);
        Gear {
            transverse_pressure_angle,
            base_radius: reference * transverse_pressure_angle.cos(),
            base_helix_angle: (data.helix_angle.sin() * data.pressure_angle.cos()).asin(),
            tip_radius: tip,
            root_radius: root,
            data,
        }
    }

    /// The datum that circles depend on, as a path.
    pub(crate) fn given_circle(&self) -> &'static str {
        match (self.data.tip_diameter, self.data.root_diameter) {
            (Some(_), _) => "tip_diameter_mm",
            (None, Some(_)) => "root_diameter_mm",
            (None, None) => "profile_shift_coefficient",
        }
    }

    /// The message for a number that no tooth has.
    pub(crate) fn no_such_tooth(&self, tooth: u32) -> Option<String> {
        let teeth = self.data.teeth;
        let there = (1..=teeth).contains(&tooth);
        (!there).then(|| format!("{tooth} is not within 1 and {teeth}, the number of teeth"))
    }

    /// Returns the data as given.
    pub fn data(&self) -> &GearData {
        &self.data
    }

    /// z.
    pub fn teeth(&self) -> f64 {
        f64::from(self.data.teeth)
    }

    /// +1 where teeth point outwards, −1 on internal gears.
    pub fn outward(&self) -> f64 {
        if self.data.internal { -1.0 } else { 1.0 }
    }

    /// +1 for a right-hand helix, −1 for a left-hand one.
    pub fn hand(&self) -> f64 {
        match self.data.hand {
            Hand::Right => 1.0,
            Hand::Left => -1.0,
        }
    }

    /// m_t = m_n / cos β.
    pub fn transverse_module(&self) -> f64 {
        self.data.normal_module / self.data.helix_angle.cos()
    }

    /// α_t: tan α_t = tan α_n / cos β.
    pub fn transverse_pressure_angle(&self) -> f64 {
        self.transverse_pressure_angle
    }

    /// d/2 = z m_n / (2 cos β).
    pub fn reference_radius(&self) -> f64 {
        0.5 * self.teeth() * self.transverse_module()
    }

    /// r_b = d cos α_t / 2.
    pub fn base_radius(&self) -> f64 {
        self.base_radius
    }

    /// β_b: sin β_b = sin β cos α_n.
    pub fn base_helix_angle(&self) -> f64 {
        self.base_helix_angle
    }

    /// d_a/2, given or with an addendum of (1 + x) m_n.
    pub fn tip_radius(&self) -> f64 {
        self.tip_radius
    }

    /// d_f/2, given or with a dedendum of (h_aP0* − x) m_n.
    pub fn root_radius(&self) -> f64 {
        self.root_radius
    }

    /// 2π / z.
    pub fn pitch_angle(&self) -> f64 {
        2.0 * PI / self.teeth()
    }

    /// Transverse base pitch p_bt = π m_t cos α_t.
    pub fn base_pitch(&self) -> f64 {
        PI * self.transverse_module() * self.transverse_pressure_angle.cos()
    }

    /// Half angle of a tooth on the reference circle, ψ = (π/2 + 2 x tan α_n) / z.
    pub fn half_tooth_angle(&self) -> f64 {
        (FRAC_PI_2 + 2.0 * self.data.profile_shift * self.data.pressure_angle.tan()) / self.teeth()
    }

    /// How far a section turns per mm of z, rad, counterclockwise for the viewer.
    pub fn turn_per_length(&self) -> f64 {
        self.hand() * self.base_helix_angle.tan() / self.base_radius
    }

    /// Roll length √(r² − r_b²) of a diameter, mm; `None` below the base circle.
    ///
    /// ```
    /// use flankfit_gear::{Gear, GearData};
    ///
    /// // 52 teeth of module 1: r_b = 26 cos 20°, and on the reference circle L = 26 sin 20°.
    /// let gear = Gear::new(GearData::spur(52, 1.0))?;
    /// let roll_length = gear.roll_length(52.0).unwrap();
    /// assert!((roll_length - 26.0 * 20_f64.to_radians().sin()).abs() < 1e-12);
    /// assert_eq!(gear.roll_length(48.0), None); // below the base circle
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn roll_length(&self, diameter: f64) -> Option<f64> {
        let r = 0.5 * diameter;
        (r >= self.base_radius).then(|| ((r - self.base_radius) * (r + self.base_radius)).sqrt())
    }

    /// Diameter at a roll length, mm.
    pub fn diameter(&self, roll_length: f64) -> f64 {
        2.0 * self.base_radius.hypot(roll_length)
    }
}
