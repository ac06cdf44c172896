//! Sensitivities of machines that grind cylindrical gears: what one unit of each setting does to
//! the flank.
//!
//! A column holds, for each node, the deviation along the normal of the nominal flank (µm, + =
//! material left standing) after one unit more of the setting: the derivative of the nominal
//! generator by that setting at a fixed node. All of them are exact: a flank that moves with the
//! velocity w at the node protrudes by `w · n`, and a flank of other gear data turns about the
//! axis by what ψ, inv and r_b change.
//!
//! docs/reference/machine-settings.md shows each setting on both flanks.
//!
//! With `u = −1…1` over the evaluated roll lengths and `v = −1…1` over the evaluated z, s = ±1 on
//! left and right flanks:
//!
//! | setting | unit | machine | deviation for one unit more |
//! |---|---|---|---|
//! | `profile_angle` | ′ | both | tool's normal pressure angle, for each rad `cos β_b (2 x r_b / (z cos² α_n) − τ tan α_t (dα_t/dα_n) (L − L_0))`: about −0.106 µm for each ′ and mm of roll length at 20° |
//! | `helix_angle` | ′ | both | signed helix angle made (right hand above 0), turning about the middle of the evaluated z: `s (z − z_m) cos α_n / cos β` for each rad, whatever the hand |
//! | `profile_crowning` | µm | both | `−u²` |
//! | `helix_crowning` | µm | both | form grinding `−v²`; generating grinding `−v_t²`, see below |
//! | `twist` | µm | generating | `uv/4`: the twist 4c_uv of the second-order surface grows by 1 µm |
//! | `tooth_thickness` | µm | both | normal tooth thickness on the reference cylinder: `½ cos α_n` on both flanks |
//! | `infeed` | µm | form | wheel moved away from the gear's axis: the gap moves outwards as it is |
//! | `tool_axis_offset` | µm | both | tool moved to the left (−x) in the gap that it is in (generating: in the pitch plane, across its teeth, `s cos α_n`): left flanks keep what right flanks lose |
//!
//! **Generating grinding.** The worm rolls with the gear as a rack does, so moving it along or
//! across the pitch plane moves each flank along its normal by the same amount everywhere: the
//! tooth thickness *is* the infeed (`½ cos α_n` for one µm of thickness), and there is no setting
//! `infeed`. The worm touches the flank at one point, which runs along the normal through the pitch
//! point; a node is made when the tool is at `z_t = z + σ h (L − L_0) tan β_b` (L_0 on the
//! reference circle), not at z. A crowning made by infeed over z_t therefore comes with a **natural
//! twist** on helical gears: v_t differs from v by `2 σ h (L − L_0) tan β_b / b`, and `−v_t²` has a
//! mixed term. Shifting the worm along a dressed profile makes twist alone.
//!
//! **Form grinding.** The wheel has the shape of the gap and leaves it in every section, moved as
//! the wheel is moved. `infeed` and `tool_axis_offset` therefore change the profile with the
//! direction of its normal; the thickness is set by turning the gear between the passes of left and
//! right flanks. The contact of wheel and gap is taken to lie in one transverse section, so a
//! crowning over z has no natural twist and there is no setting that makes twist alone.

use super::problem::Setting;
use crate::{Gear, Side, involute::Flank};
use flankfit_geometry::space::Vector;
use flankfit_numerics::{cancel::Asking, check::Faults, words::Shown};

/// One arc-minute, rad.
const MINUTE: f64 = std::f64::consts::PI / 10_800.0;
/// µm in a mm.
const MICRO: f64 = 1e3;

/// A machine that grinds cylindrical gears. Deviations are along the normal, + = material left
/// standing; s is +1 on left and −1 on right flanks, u and v run from −1 to 1 over the ranges from
/// root to tip and along z. docs/reference/machine-settings.md has a figure of each setting.
///
/// | setting | unit | a positive change | what the flank gets |
/// |---|---|---|---|
/// | `profile_angle` | arcmin | greater normal pressure angle of the tool | less material at the tip on both flanks: f_Hα falls |
/// | `helix_angle` | arcmin | signed helix angle grows (as `helix_angle_deg`, right hand above 0) | f_Hβ (DIN) grows on both flanks of gears of either hand |
/// | `profile_crowning` | µm | more removed at root and tip | −u²: C_α grows by as much |
/// | `helix_crowning` | µm | more removed at both ends | −v² (form), −v_t² at the place of the worm (generating, with a natural twist on helical gears): C_β grows |
/// | `twist` | µm | generating only: worm shifted along a dressed profile | uv/4 on both flanks: 4c_uv grows by as much |
/// | `tooth_thickness` | µm | thicker tooth | ½ cos α_n on both flanks: no slope, no crowning |
/// | `infeed` | µm | form only: wheel away from the gear's axis | material on both flanks, more towards the tip |
/// | `tool_axis_offset` | µm | tool to the left (−x) in its gap | material on left flanks, the same off right flanks |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum Machine {
    /// With a worm that rolls with the gear.
    GeneratingGrinding,
    /// With a wheel of the shape of the gap.
    FormGrinding,
}

/// A node of a flank of the tooth at the top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlankNode {
    /// Flank of the tooth that the node is on.
    pub side: Side,
    /// mm.
    pub roll_length: f64,
    /// mm.
    pub z: f64,
}

/// Ranges that crownings and twist refer to, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ranges {
    /// Roll lengths, from root to tip: ascending on external gears, descending on internal ones.
    pub profile: [f64; 2],
    /// z, ascending.
    pub helix: [f64; 2],
}

/// Settings with their sensitivity matrix, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity {
    /// The settings of the columns.
    pub settings: Vec<Setting>,
    /// µm per unit, `matrix[k * settings.len() + j]`.
    pub matrix: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    ProfileAngle,
    HelixAngle,
    ProfileCrowning,
    HelixCrowning,
    Twist,
    ToothThickness,
    Infeed,
    ToolAxisOffset,
}

impl Kind {
    fn setting(self) -> Setting {
        let (name, unit) = match self {
            Kind::ProfileAngle => ("profile_angle", "arcmin"),
            Kind::HelixAngle => ("helix_angle", "arcmin"),
            Kind::ProfileCrowning => ("profile_crowning", "um"),
            Kind::HelixCrowning => ("helix_crowning", "um"),
            Kind::Twist => ("twist", "um"),
            Kind::ToothThickness => ("tooth_thickness", "um"),
            Kind::Infeed => ("infeed", "um"),
            Kind::ToolAxisOffset => ("tool_axis_offset", "um"),
        };
        Setting { twists: self == Kind::Twist, ..Setting::free(name, unit) }
    }
}

impl Machine {
    /// Stable name.
    pub fn name(self) -> &'static str {
        match self {
            Machine::GeneratingGrinding => "generating_grinding",
            Machine::FormGrinding => "form_grinding",
        }
    }

    fn kinds(self) -> [Kind; 7] {
        use Kind::*;
        match self {
            Machine::GeneratingGrinding => {
                [ProfileAngle, HelixAngle, ProfileCrowning, HelixCrowning, Twist, ToothThickness, ToolAxisOffset]
            }
            Machine::FormGrinding => {
                [ProfileAngle, HelixAngle, ProfileCrowning, HelixCrowning, ToothThickness, Infeed, ToolAxisOffset]
            }
        }
    }

    /// The settings, in the order of the columns.
    pub fn settings(self) -> Vec<Setting> {
        self.kinds().map(Kind::setting).to_vec()
    }

    /// J at the nodes. Refuses ranges without length and nodes that are no places on an involute.
    ///
    /// ```
    /// use flankfit_gear::{
    ///     Gear, GearData, Side,
    ///     correction::machine::{FlankNode, Machine, Ranges},
    /// };
    ///
    /// let gear = Gear::new(GearData { face_width: Some(20.0), ..GearData::spur(52, 1.0) })?;
    /// let nodes: Vec<FlankNode> =
    ///     [0.0, 10.0, 20.0].map(|z| FlankNode { side: Side::Left, roll_length: 9.0, z }).into();
    /// let ranges = Ranges { profile: [8.0, 10.0], helix: [0.0, 20.0] };
    /// let found = Machine::FormGrinding.sensitivity(&gear, &nodes, ranges)?;
    /// // One row for each node, one column for each setting.
    /// assert_eq!(found.matrix.len(), nodes.len() * found.settings.len());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn sensitivity(self, gear: &Gear, nodes: &[FlankNode], ranges: Ranges) -> Result<Sensitivity, Faults> {
        check(nodes, ranges)?;
        let made = Made { machine: self, gear, ranges };
        let kinds = self.kinds();
        let matrix = nodes.iter().asking(2000).flat_map(|node| kinds.map(|kind| made.deviation(kind, *node))).collect();
        Ok(Sensitivity { settings: self.settings(), matrix })
    }
}

/// A gear on its machine.
struct Made<'a> {
    machine: Machine,
    gear: &'a Gear,
    ranges: Ranges,
}

impl Made<'_> {
    /// Deviation for one unit of a setting, µm.
    fn deviation(&self, kind: Kind, node: FlankNode) -> f64 {
        let gear = self.gear;
        let middle = |range: [f64; 2]| 0.5 * (range[0] + range[1]);
        let along = |x: f64, range: [f64; 2]| 2.0 * (x - middle(range)) / (range[1] - range[0]);
        let (u, v) = (along(node.roll_length, self.ranges.profile), along(node.z, self.ranges.helix));
        let sign = node.side.sign();
        match kind {
            Kind::ProfileAngle => MICRO * MINUTE * self.pressure_angle(node),
            Kind::HelixAngle => {
                // d(tan β)/dβ = 1/cos²β of the signed angle, which turns counterclockwise on the
                // way to the viewer; a turn by θ moves the flank by s θ r_b cos β_b along its
                // normal
                let turn = MINUTE / (gear.data().helix_angle.cos().powi(2) * gear.reference_radius());
                let lever = gear.base_radius() * gear.base_helix_angle().cos();
                MICRO * sign * lever * turn * (node.z - middle(self.ranges.helix))
            }
            Kind::ProfileCrowning => -u * u,
            Kind::HelixCrowning => match self.machine {
                Machine::FormGrinding => -v * v,
                Machine::GeneratingGrinding => -along(self.tool_position(node), self.ranges.helix).powi(2),
            },
            Kind::Twist => 0.25 * u * v,
            Kind::ToothThickness => 0.5 * gear.data().pressure_angle.cos(),
            Kind::Infeed => self.gap_moved(node, 0.0, 1.0),
            Kind::ToolAxisOffset => match self.machine {
                Machine::GeneratingGrinding => sign * gear.data().pressure_angle.cos(),
                Machine::FormGrinding => self.gap_moved(node, -1.0, 0.0),
            },
        }
    }

    /// Protrusion of a flank for each rad more of the normal pressure angle, mm. At a fixed
    /// radius inv α changes with the base radius by −L / r_b², so that base circle and start of the
    /// involute together leave a straight line over the roll length.
    fn pressure_angle(&self, node: FlankNode) -> f64 {
        let (gear, data) = (self.gear, self.gear.data());
        let transverse = gear.transverse_pressure_angle();
        let square = data.pressure_angle.cos().powi(2);
        let more_transverse = transverse.cos().powi(2) / (data.helix_angle.cos() * square);
        let thicker = gear.base_radius() * 2.0 * data.profile_shift / (gear.teeth() * square);
        let steeper = gear.outward() * transverse.tan() * more_transverse * (node.roll_length - self.reference_roll());
        gear.base_helix_angle().cos() * (thicker - steeper)
    }

    /// L_0.
    fn reference_roll(&self) -> f64 {
        self.gear.base_radius() * self.gear.transverse_pressure_angle().tan()
    }

    /// Returns the position of a worm when it makes a node.
    fn tool_position(&self, node: FlankNode) -> f64 {
        let gear = self.gear;
        let sense = node.side.sign() * gear.outward();
        node.z + sense * gear.hand() * (node.roll_length - self.reference_roll()) * gear.base_helix_angle().tan()
    }

    /// Deviation when the gap next to a flank moves by (x, y) in its section, its middle pointing
    /// up.
    fn gap_moved(&self, node: FlankNode, x: f64, y: f64) -> f64 {
        let normal = Flank::new(self.gear, node.side).at(node.roll_length, 0.0).normal;
        // the gap next to the left flank lies half a pitch counterclockwise
        let (sin, cos) = (node.side.sign() * std::f64::consts::PI / self.gear.teeth()).sin_cos();
        let moved = Vector::new(cos * x - sin * y, sin * x + cos * y, 0.0);
        moved.dot(&normal)
    }
}

fn check(nodes: &[FlankNode], ranges: Ranges) -> Result<(), Faults> {
    let mut faults = Faults::default();
    let [from, to] = ranges.profile;
    if !(from.is_finite() && to.is_finite() && from != to) {
        let [from, to] = ranges.profile.map(Shown);
        let message = format_args!("{from} to {to} mm is not a range of roll lengths");
        faults.push("profile_diameter_range_mm", message);
    }
    let [from, to] = ranges.helix;
    if !(from.is_finite() && to.is_finite() && from < to) {
        let [from, to] = ranges.helix.map(Shown);
        faults.push("helix_range_mm", format_args!("{from} to {to} mm is not an ascending range of z"));
    }
    if nodes.is_empty() {
        faults.push("nodes", "0 nodes; at least one is needed");
    }
    for (k, place) in nodes.iter().enumerate().asking(1000) {
        if !(0.0..=1e6).contains(&place.roll_length) {
            let roll_length = Shown(place.roll_length);
            let message = format_args!("{roll_length} is not a roll length of at least 0 mm");
            faults.push(format_args!("nodes[{k}].roll_length_mm"), message);
        }
        if !(place.z.abs() <= 1e6) {
            let z = Shown(place.z);
            faults.push(format_args!("nodes[{k}].z_mm"), format_args!("{z} is not a place on a gear, mm"));
        }
    }
    faults.into_result(())
}
