//! The fillet that a rack tool's tip leaves on an external gear, in closed form.
//!
//! The rack lies with its datum line x m_n outside the pitch line, which rolls on the reference
//! circle. u runs along the pitch line, w outwards from it, u = 0 in the middle of the gear's
//! tooth. A tool point (u, w) with the normal (n_u, n_w) cuts where its normal passes through the
//! pitch point (n · v = 0), after the gear has turned by θ = (u − w q)/r, q = n_u/n_w, and is then
//! at `R(−θ) (w q, r + w)` in the gear.
//!
//! The tip's rounding is a circle in the tool's *normal* section. At the angle δ from its lowest
//! point, with centre (c, w_c) and radius ρ,
//!
//! `u = (c + ρ sin δ)/cos β,  w = w_c − ρ cos δ,  q = −tan δ cos β`:
//!
//! in the transverse section an ellipse. A protuberance pr puts the centre ρ − pr behind the
//! straight flank instead of ρ; the rounding then reaches up to where it crosses that flank, in a
//! concave corner (a protuberance flank of another angle is not described by the data). Where it
//! bends back after δ = π/2 it cuts on the other side of the pitch point; with a rounding near the
//! pitch line, on gears of much profile shift, that overhang cuts the flank once more, and the
//! nearer of both cuts is what counts. ρ = 0 is a sharp corner, whose normals fill the angle
//! between tip and flank: the same formulas.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use super::Polar;
use crate::{Gear, Side, check::degrees, involute::Flank};
use flankfit_numerics::{
    cancel::Asking,
    check::Faults,
    root::boundary,
    words::{Shown, rounded},
};

/// Tip radius where no tool is given: the fillet radius ρ_fP* of ISO 53, profile A, in normal
/// modules.
pub const STANDARD_TIP_RADIUS: f64 = 0.38;

/// Lengths along the fillet are measured in so many steps for each point that is wanted.
const FINER: usize = 8;
/// Radii at which an overhang is compared with the involute.
const OVERHANG: usize = 400;

/// A rack tool in its normal section, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RackTool {
    /// Height of the tip above the datum line: h_aP0* m_n.
    pub addendum: f64,
    /// Radius of the tip's rounding; 0 for a sharp corner.
    pub tip_radius: f64,
    /// Distance by which the tip protrudes sideways from the straight flank.
    pub protuberance: f64,
    /// Whether the gear's data name it; else it is the standard one that reaches the root circle.
    pub given: bool,
}

impl RackTool {
    /// The tool of an external gear; `None` where no tool is given and no rack reaches the root
    /// circle.
    pub fn of(gear: &Gear) -> Option<Self> {
        let data = gear.data();
        if data.internal {
            return None;
        }
        if let Some(tool) = data.tool {
            return Some(RackTool {
                addendum: tool.addendum_factor * data.normal_module,
                tip_radius: tool.tip_radius,
                protuberance: tool.protuberance,
                given: true,
            });
        }
        let addendum = gear.reference_radius() + data.profile_shift * data.normal_module - gear.root_radius();
        let full = full_radius(gear, addendum, 0.0);
        let tip_radius = full.min(STANDARD_TIP_RADIUS * data.normal_module);
        (addendum > 0.0 && full >= 0.0).then_some(RackTool { addendum, tip_radius, protuberance: 0.0, given: false })
    }
}

/// The tip radius at which a tool's tip is all round, mm; below 0 where its flanks meet before its
/// tip.
fn full_radius(gear: &Gear, addendum: f64, protuberance: f64) -> f64 {
    let data = gear.data();
    let (sin, cos) = data.pressure_angle.sin_cos();
    (FRAC_PI_4 * data.normal_module * cos - addendum * sin + protuberance) / (1.0 - sin)
}

/// Refuses tools that cannot exist.
pub fn check(gear: &Gear) -> Result<(), Faults> {
    let mut faults = Faults::default();
    let Some(tool) = RackTool::of(gear).filter(|tool| tool.given) else { return Ok(()) };
    let full = full_radius(gear, tool.addendum, tool.protuberance);
    if tool.protuberance > tool.tip_radius {
        let [protuberance, tip_radius] = [tool.protuberance, tool.tip_radius].map(Shown);
        faults.push(
            "tool.protuberance_mm",
            format_args!(
                "{protuberance} mm is more than the tip radius of {tip_radius} mm: the rounding would not reach the \
                 straight flank"
            ),
        );
    } else if full < 0.0 {
        let (addendum, angle) = (Shown(tool.addendum), degrees(gear.data().pressure_angle));
        faults.push(
            "tool.addendum_factor",
            format_args!(
                "the flanks of the tool meet before its tip, an addendum of {addendum} mm at a pressure angle of {angle}°"
            ),
        );
    } else if tool.tip_radius > full {
        let [tip_radius, most] = [tool.tip_radius, full].map(|x| rounded(x, 7));
        faults.push(
            "tool.tip_radius_mm",
            format_args!("{tip_radius} mm does not fit into the tool's tip, which allows {most} mm"),
        );
    }
    let depth = tool.addendum - gear.data().profile_shift * gear.data().normal_module;
    if !(depth < gear.reference_radius()) {
        faults.push("tool.addendum_factor", "the tool cuts through the gear's axis");
    }
    faults.into_result(())
}

/// Fillet that a rack tool leaves on an external gear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RackFillet {
    /// The tool that cuts it.
    pub tool: RackTool,
    pitch_radius: f64,
    cos_helix: f64,
    /// Centre of the rounding in the normal section.
    centre: [f64; 2],
    /// δ where the rounding gives way to the straight flank.
    last: f64,
    /// Roll length that the lowest point of the straight flank generates; below 0 where it lies
    /// below the base tangent point.
    straight_roll: f64,
    /// Roll length at which fillet and involute meet.
    form_roll: f64,
    form_angle: f64,
    /// δ where the overhang of a rounding that reaches more than π/2 cuts nearest to the gear's
    /// axis.
    dip: Option<f64>,
}

impl RackFillet {
    /// The fillet of `tool`, with the place where it meets the involute.
    pub fn new(gear: &Gear, tool: RackTool) -> Self {
        let data = gear.data();
        let (sin, cos) = data.pressure_angle.sin_cos();
        let shift = data.profile_shift * data.normal_module;
        let above_datum = tool.tip_radius - tool.addendum;
        let behind = tool.protuberance - tool.tip_radius;
        let centre = [-FRAC_PI_4 * data.normal_module + (above_datum * sin + behind) / cos, shift + above_datum];
        let touching = FRAC_PI_2 - data.pressure_angle;
        let beyond = if tool.protuberance > 0.0 { (-behind / tool.tip_radius).clamp(-1.0, 1.0).acos() } else { 0.0 };
        let last = touching + beyond;
        let sin_t = gear.transverse_pressure_angle().sin();
        let roll_of =
            |delta: f64| gear.reference_radius() * sin_t + (centre[1] - tool.tip_radius * delta.cos()) / sin_t;
        let mut fillet = RackFillet {
            tool,
            pitch_radius: gear.reference_radius(),
            cos_helix: data.helix_angle.cos(),
            centre,
            last,
            straight_roll: roll_of(last),
            form_roll: 0.0,
            form_angle: last,
            dip: None,
        };
        if tool.protuberance == 0.0 && fillet.straight_roll >= 0.0 {
            fillet.form_roll = fillet.straight_roll;
        } else {
            let from = if roll_of(touching) > 0.0 { touching } else { fillet.angle_at(gear.base_radius()) };
            (fillet.form_angle, fillet.form_roll) = fillet.crossing(gear, from);
            fillet.dip = fillet.dip_of_overhang();
            fillet.form_roll = fillet.form_roll.max(fillet.overhang_crossing(gear).unwrap_or(0.0));
        }
        fillet
    }

    /// The crossing of fillet and involute above `from`: the angle δ, and the roll length.
    fn crossing(&self, gear: &Gear, from: f64) -> (f64, f64) {
        let flank = Flank::new(gear, Side::Left);
        let roll = |delta: f64| gear.roll_length(2.0 * self.at(delta).radius).unwrap_or(0.0);
        let outside = |delta: f64| self.at(delta).half_angle >= flank.half_angle(roll(delta));
        // Beyond a right angle the rounding cuts nothing: its normal no longer reaches the pitch
        // line ahead of it.
        let [_, out] = boundary([from, self.last.min(FRAC_PI_2 - 1e-6).max(from)], 0.0, |delta| !outside(delta));
        (out, roll(out))
    }

    /// δ at a radius between root and the end of the rounding; radii grow with δ.
    pub fn angle_at(&self, radius: f64) -> f64 {
        let ends = [0.0, self.last.min(FRAC_PI_2 - 1e-6)];
        boundary(ends, 0.0, |delta| self.at(delta).radius < radius)[1]
    }

    /// The overhang's δ of least radius: the radius falls from infinity at π/2, and may
    /// rise again.
    fn dip_of_overhang(&self) -> Option<f64> {
        let (mut low, mut high) = (FRAC_PI_2 + 1e-6, self.last);
        if !(low < high) {
            return None;
        }
        for _ in 0..200 {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if !(low < a && a < b && b < high) {
                break;
            }
            if self.at(a).radius < self.at(b).radius { high = b } else { low = a }
        }
        Some(0.5 * (low + high))
    }

    /// Half the tooth's angle that the overhang leaves at a radius; `None` where it does not pass.
    fn overhang(&self, radius: f64) -> Option<f64> {
        let dip = self.dip?;
        let cut = |falling: f64, rising: f64| {
            if !(self.at(falling).radius >= radius && radius >= self.at(rising).radius) {
                return None;
            }
            let [above, _] = boundary([falling, rising], 0.0, |delta| self.at(delta).radius >= radius);
            Some(self.at(above).half_angle)
        };
        let (before, after) = (cut(FRAC_PI_2 + 1e-6, dip), cut(self.last, dip));
        before.into_iter().chain(after).reduce(f64::min)
    }

    /// The greatest roll length up to the tip at which the overhang cuts into the involute.
    fn overhang_crossing(&self, gear: &Gear) -> Option<f64> {
        let flank = Flank::new(gear, Side::Left);
        let least = self.at(self.dip?).radius.max(gear.base_radius());
        let most = gear.tip_radius();
        let cuts = |radius: f64| {
            let involute = gear.roll_length(2.0 * radius).map(|roll| flank.half_angle(roll));
            self.overhang(radius).zip(involute).is_some_and(|(cut, involute)| cut < involute - 1e-12)
        };
        let radius = |k: usize| least + (most - least) * k as f64 / OVERHANG as f64;
        let last = (0..=OVERHANG).rev().find(|k| least < most && cuts(radius(*k)))?;
        let [cut, _] = boundary([radius(last), radius((last + 1).min(OVERHANG))], 0.0, cuts);
        gear.roll_length(2.0 * cut)
    }

    /// The tool's transverse point (u, w) and the slope q = n_u/n_w of its normal at δ.
    pub fn tool_point(&self, delta: f64) -> ([f64; 2], f64) {
        let (sin, cos) = delta.sin_cos();
        let [c, height] = self.centre;
        let u = (c + self.tool.tip_radius * sin) / self.cos_helix;
        ([u, height - self.tool.tip_radius * cos], -sin / cos * self.cos_helix)
    }

    /// Returns the place that the tool's point at δ cuts, 0 ≤ δ < π/2.
    pub fn at(&self, delta: f64) -> Polar {
        let ([u, w], q) = self.tool_point(delta);
        let (along, out) = (w * q, self.pitch_radius + w);
        Polar { radius: along.hypot(out), half_angle: (-along).atan2(out) - (u - along) / self.pitch_radius }
    }

    /// The root circle that the tool cuts, mm.
    pub fn root_radius(&self) -> f64 {
        self.pitch_radius + self.centre[1] - self.tool.tip_radius
    }

    /// Roll length at which the fillet meets the involute.
    pub fn form_roll(&self) -> f64 {
        self.form_roll
    }

    /// δ there, or where fillet and involute would meet but for an overhang that cuts the involute
    /// above.
    pub fn form_angle(&self) -> f64 {
        self.form_angle
    }

    /// Whether the straight flank reaches below the base tangent point, so that the tip cuts into
    /// the involute.
    pub fn undercut(&self) -> bool {
        self.straight_roll < -1e-12 * self.pitch_radius
    }

    /// The smallest profile shift coefficient without undercut: the straight flank ends at the base
    /// tangent point.
    pub fn least_shift(&self, gear: &Gear) -> f64 {
        let sin_t = gear.transverse_pressure_angle().sin();
        gear.data().profile_shift - self.straight_roll * sin_t / gear.data().normal_module
    }

    /// About `count` + 1 points from the root circle to where the involute starts, or to `most` if
    /// it starts above that radius; about equally far from each other, which equal steps of δ are
    /// not.
    pub fn points(&self, gear: &Gear, count: usize, most: f64) -> Vec<Polar> {
        let count = count.max(1);
        let form = (0.5 * gear.diameter(self.form_roll)).min(most);
        match self.dip.map(|dip| self.at(dip).radius).filter(|dip| *dip < form) {
            None if form < most => self.smooth(self.form_angle, count),
            None => self.smooth(self.angle_at(most), count),
            Some(dip) => {
                // From where either cut could be the nearer one, and with the piece of involute
                // that may stand between both.
                let flank = Flank::new(gear, Side::Left);
                let meets = self.at(self.form_angle).radius;
                let from = dip.min(meets);
                let mut points = self.smooth(self.angle_at(from), count);
                points.extend((1..=count).map(|k| {
                    let radius = from + (form - from) * k as f64 / count as f64;
                    let fillet = self.at(self.angle_at(radius)).half_angle;
                    let involute = gear.roll_length(2.0 * radius).filter(|_| radius >= meets);
                    let involute = involute.map(|roll| flank.half_angle(roll));
                    let cuts = self.overhang(radius).into_iter().chain(involute);
                    Polar { radius, half_angle: cuts.fold(fillet, f64::min) }
                }));
                points
            }
        }
    }

    /// Points from the root circle to δ = `end`, about equally far from each other.
    fn smooth(&self, end: f64, count: usize) -> Vec<Polar> {
        let fine = FINER * count;
        let delta = |k: f64| end * k / fine as f64;
        let mut along = vec![0.0; fine + 1];
        let mut last = self.at(0.0).point(1.0, 0.0);
        for k in (1..=fine).asking(500) {
            let next = self.at(delta(k as f64)).point(1.0, 0.0);
            along[k] = along[k - 1] + (next[0] - last[0]).hypot(next[1] - last[1]);
            last = next;
        }
        let point = |k: usize| {
            let wanted = along[fine] * k as f64 / count as f64;
            let after = along.partition_point(|length| *length < wanted).clamp(1, fine);
            let step = along[after] - along[after - 1];
            let share = if step > 0.0 { ((wanted - along[after - 1]) / step).clamp(0.0, 1.0) } else { 1.0 };
            self.at(delta((after - 1) as f64 + share))
        };
        (0..count).asking(500).map(point).chain([self.at(end)]).collect()
    }
}
