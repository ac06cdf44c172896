//! The whole tooth as a transverse profile at z = 0: fillets, involutes, tip arc, root arc.
//!
//! Every part ends where the next one begins, so a closed profile crosses itself nowhere: the
//! fillet is taken up to the root form diameter, the involute from there to the tip or to where the
//! flanks meet. A gear of which the tool leaves no involute, or whose fillets meet within the
//! tooth, has no profile.

use super::{Polar, Root};
use crate::{Gear, Side, check::no_space, geometry::pointed_diameter, involute::Flank};
use flankfit_numerics::{
    cancel,
    check::Faults,
    words::{counted, rounded},
};

/// Most points of the teeth of a gear.
pub const MOST_TOOTH_POINTS: usize = 2_000_000;

/// Numbers of steps of the parts of a tooth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = ProfileSteps),
    serde(deny_unknown_fields, default)
)]
pub struct Steps {
    /// Number of steps of each involute.
    #[cfg_attr(feature = "contract", schema(minimum = 1))]
    pub involute: usize,
    /// Number of steps of each fillet.
    #[cfg_attr(feature = "contract", schema(minimum = 1))]
    pub fillet: usize,
    /// Number of steps of the tip's arc.
    #[cfg_attr(feature = "contract", schema(minimum = 1))]
    pub tip: usize,
    /// Number of steps of the arc between two teeth.
    #[cfg_attr(feature = "contract", schema(minimum = 1))]
    pub root: usize,
}

impl Default for Steps {
    fn default() -> Self {
        Steps { involute: 40, fillet: 30, tip: 8, root: 8 }
    }
}

impl Steps {
    /// Points of one tooth and the space next to it, or a few more.
    pub fn points(&self) -> usize {
        let parts = [self.involute, self.fillet, self.tip, self.root];
        parts.iter().fold(4, |sum, part| sum.saturating_add(part.saturating_mul(2)))
    }
}

/// The transverse section of a gear's teeth.
#[derive(Clone, Debug, PartialEq)]
pub struct Tooth {
    /// The left flank from the root circle to the tip.
    flank: Vec<Polar>,
    steps: Steps,
    internal: bool,
    teeth: u32,
    pitch_angle: f64,
}

impl Tooth {
    /// The tooth that root, flank and tip of `gear` make.
    pub fn new(gear: &Gear, steps: Steps) -> Result<Self, Faults> {
        let parts = [steps.involute, steps.fillet, steps.tip, steps.root];
        let sum = steps.points();
        if parts.contains(&0) || sum.saturating_mul(gear.data().teeth as usize) > MOST_TOOTH_POINTS {
            let points = counted(sum, "point", "points");
            return Err(Faults::one(
                "steps",
                format_args!(
                    "{points} for each tooth; every part has a step, and a gear {MOST_TOOTH_POINTS} points at most"
                ),
            ));
        }
        let root = Root::of(gear);
        let flank = Flank::new(gear, Side::Left);
        let tip = gear.tip_radius();
        let point = pointed_diameter(gear).map(|d| 0.5 * d).filter(|point| gear.outward() * (tip - point) >= 0.0);
        let reached = point.unwrap_or(tip);
        let mut points = root.points(steps.fillet, reached, gear);
        let tip_roll = gear.roll_length(2.0 * reached).unwrap_or(0.0);
        let form_roll = root.form_roll();
        if !(gear.outward() * (tip_roll - form_roll) > 0.0) {
            let [from, end] = [gear.diameter(form_roll), 2.0 * reached].map(|x| rounded(x, 7));
            let message = format_args!(
                "there is no involute: it would start on {from} mm, outside the end of the tooth on {end} mm"
            );
            return Err(Faults::one(gear.given_circle(), message).within("gear"));
        }
        points.extend((1..=steps.involute).map(|k| {
            // Equal steps of the roll angle's square, which is the arc length: the involute starts
            // with an infinite curvature.
            let t = k as f64 / steps.involute as f64;
            let roll = (form_roll * form_roll + t * (tip_roll - form_roll) * (tip_roll + form_roll)).max(0.0).sqrt();
            let meets = k == steps.involute && point.is_some();
            let half_angle = if meets { 0.0 } else { flank.half_angle(roll) };
            Polar { radius: 0.5 * gear.diameter(roll), half_angle }
        }));
        if let Some(last) = points.last().copied().filter(|last| gear.data().internal && last.radius > tip) {
            // Below the base circle an internal tooth goes on radially.
            let below = reached < gear.base_radius();
            points.extend(below.then_some(Polar { radius: tip, half_angle: last.half_angle }));
        }
        let tooth = Tooth {
            flank: points,
            steps,
            internal: gear.data().internal,
            teeth: gear.data().teeth,
            pitch_angle: gear.pitch_angle(),
        };
        tooth.check(gear)?;
        Ok(tooth)
    }

    /// A tooth has material everywhere but in its very tip, and leaves a space.
    fn check(&self, gear: &Gear) -> Result<(), Faults> {
        let inner = self.flank.len().saturating_sub(1);
        let cut_off = |(k, p): &(usize, &Polar)| !(p.half_angle > 0.0 || (*k == inner && p.half_angle == 0.0));
        if let Some((_, cut)) = self.flank.iter().enumerate().find(cut_off) {
            let path = if gear.data().tool.is_some() { "gear.tool" } else { "gear.profile_shift_coefficient" };
            let diameter = rounded(2.0 * cut.radius, 7);
            return Err(Faults::one(path, format_args!("the tool cuts the teeth off on {diameter} mm")));
        }
        let wide = |p: &&Polar| !(p.half_angle <= 0.5 * self.pitch_angle * (1.0 + 1e-12));
        if let Some(closed) = self.flank.iter().find(wide) {
            return Err(Faults::one("gear.profile_shift_coefficient", no_space(2.0 * closed.radius)));
        }
        Ok(())
    }

    /// The left flank from the root circle to the tip; the right one is its mirror image.
    pub fn flank(&self) -> &[Polar] {
        &self.flank
    }

    /// Right flank from the root, tip arc, left flank to the root: counterclockwise about the
    /// gear's axis, at `turn`.
    fn open(&self, turn: f64) -> Vec<[f64; 2]> {
        let mut points: Vec<[f64; 2]> = self.flank.iter().map(|p| p.point(-1.0, turn)).collect();
        if let Some(tip) = self.flank.last() {
            points.extend(arc(*tip, self.steps.tip, -tip.half_angle, tip.half_angle, turn));
            // Flanks that meet have one point in common.
            let skip = usize::from(tip.half_angle == 0.0);
            points.extend(self.flank.iter().rev().skip(skip).map(|p| p.point(1.0, turn)));
        }
        points
    }

    /// One tooth, closed along the root circle beneath it: counterclockwise, without the first
    /// point once more.
    pub fn closed(&self) -> Vec<[f64; 2]> {
        let mut points = self.open(0.0);
        if let Some(root) = self.flank.first() {
            points.extend(arc(*root, self.steps.root, root.half_angle, -root.half_angle, 0.0));
        }
        if self.internal {
            points.reverse();
        }
        points
    }

    /// All teeth with the root arcs between them, counterclockwise, without the first point once
    /// more. On internal gears this is the border of the hole.
    ///
    /// ```
    /// use flankfit_gear::{Gear, GearData, generation::tooth::{Steps, Tooth}};
    ///
    /// // Closed around all 20 teeth, between the root and the tip circle.
    /// let gear = Gear::new(GearData::spur(20, 1.0))?;
    /// let section = Tooth::new(&gear, Steps::default())?.gear();
    /// let radii = || section.iter().map(|[x, y]| x.hypot(*y));
    /// let (least, most) = (radii().fold(f64::MAX, f64::min), radii().fold(0.0, f64::max));
    /// assert!((most - gear.tip_radius()).abs() < 1e-9 && least > gear.root_radius() - 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn gear(&self) -> Vec<[f64; 2]> {
        let mut points = Vec::new();
        for k in 0..self.teeth {
            cancel::checkpoint();
            let turn = f64::from(k) * self.pitch_angle;
            points.extend(self.open(turn));
            if let Some(root) = self.flank.first() {
                let next = self.pitch_angle - root.half_angle;
                if next > root.half_angle * (1.0 + 1e-12) {
                    points.extend(arc(*root, self.steps.root, root.half_angle, next, turn));
                } else {
                    // A tool with a full round tip leaves no arc: the fillets share their lowest
                    // point.
                    points.pop();
                }
            }
        }
        points
    }
}

/// The inner points of an arc of `steps` steps on the radius of `at`; none where it has no length.
fn arc(at: Polar, steps: usize, from: f64, to: f64, turn: f64) -> impl Iterator<Item = [f64; 2]> {
    let count = if from == to { 1 } else { steps };
    (1..count).map(move |k| {
        let half_angle = from + (to - from) * k as f64 / count as f64;
        Polar { radius: at.radius, half_angle }.point(1.0, turn)
    })
}
