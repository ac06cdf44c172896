//! The envelope of any cutting profile by the meshing condition, computed point by point.
//!
//! A tool's transverse profile is given as points. While tool and gear roll on each other, a point
//! of the tool can cut only when the relative velocity lies in its tangent, n · v = 0; in plane
//! rolling that is when its normal passes through the pitch point (Willis; Litvin and Fuentes, Gear
//! Geometry and Applied Theory). For both kinds of tool that instant is known in closed form:
//!
//! - **rack** (external gears): the normal meets the pitch line at u − w n_u/n_w, and the gear
//!   turns by that over r;
//! - **pinion-type** (both): the normal meets the tool's pitch circle, and tool and gear turn until
//!   that is the pitch point.
//!
//! At a corner of the profile the normals in between are taken in steps. All branches that come out
//! are kept, also those that other parts of the tool cut away again; [`Envelope::boundary`] makes
//! the flank of them: on a radius, material is left only up to the branch that comes nearest to the
//! tooth's middle. So undercut needs no case of its own.
//!
//! Frames. The gear's is the tooth's own, its middle on +y; the tool cuts the left flank. A rack's
//! points are (u, w): along the pitch line from the tooth's middle, and outwards from the pitch
//! line, so that the left flank's tool lies at u < 0. A pinion-type tool's are (x, y) from its own
//! centre with both frames parallel at the start: the tooth's middle is then below it (−y) on
//! external gears, above it (+y) on internal ones.

use super::Polar;
pub use super::tool_profile::{MOST_POINTS, ToolPoint, ToolProfile};
use flankfit_numerics::cancel::Asking;

/// Most points tried between those of the profile, so that the envelope has no gaps.
pub const MOST_BETWEEN: usize = 200_000;

/// Points that touch farther from each other than this part of the range get others in between …
const RESOLUTION: f64 = 1e-3;
/// … by halving at most so often.
const DEEPEST: usize = 24;

/// Motion of tool and gear.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(tag = "type", rename_all = "snake_case", deny_unknown_fields, expecting = "an object"),
    schema(as = ToolMotion)
)]
pub enum Motion {
    /// A rack whose pitch line rolls on the gear's circle of this radius.
    Rack {
        /// Radius of the gear's circle that rolls on the pitch line.
        #[cfg_attr(feature = "contract", serde(rename = "pitch_radius_mm"))]
        pitch_radius: f64,
    },
    /// Two pitch circles that roll on each other, the tool's inside the gear's where it is
    /// internal.
    Pinion {
        /// Radius of the tool's circle.
        #[cfg_attr(feature = "contract", serde(rename = "tool_pitch_radius_mm"))]
        tool_pitch_radius: f64,
        /// Radius of the gear's circle.
        #[cfg_attr(feature = "contract", serde(rename = "gear_pitch_radius_mm"))]
        gear_pitch_radius: f64,
        /// True for an internal gear. Default false.
        #[cfg_attr(feature = "contract", serde(default))]
        internal: bool,
    },
}

impl Motion {
    /// Place that a tool's point cuts, in the gear's frame; `None` where its normal never meets the
    /// pitch point.
    pub fn contact(&self, tool: &ToolPoint) -> Option<[f64; 2]> {
        self.contact_and_turn(tool).map(|(point, _)| point)
    }

    /// The same with the turn of the gear at that instant, rad.
    fn contact_and_turn(&self, tool: &ToolPoint) -> Option<([f64; 2], f64)> {
        let ([x, y], [nx, ny]) = (tool.point, tool.normal);
        match *self {
            Motion::Rack { pitch_radius } => {
                let along = y * nx / ny;
                let back = -(x - along) / pitch_radius;
                (along.is_finite() && back.is_finite()).then(|| (rotated([along, pitch_radius + y], back), -back))
            }
            Motion::Pinion { tool_pitch_radius, gear_pitch_radius, internal } => {
                let length = nx.hypot(ny);
                let (nx, ny) = (nx / length, ny / length);
                let foot = x * nx + y * ny;
                let root = (foot * foot + (tool_pitch_radius - x.hypot(y)) * (tool_pitch_radius + x.hypot(y))).sqrt();
                // Of the two places on the pitch circle the nearer one: the other is on the tool's
                // far side.
                let t = if foot >= 0.0 { root - foot } else { -root - foot };
                let (hit_x, hit_y) = (x + t * nx, y + t * ny);
                let (out, turn) = if internal { (1.0, (-hit_x).atan2(hit_y)) } else { (-1.0, hit_x.atan2(-hit_y)) };
                let turned = rotated([x, y], -turn);
                let centre = gear_pitch_radius - out * tool_pitch_radius;
                let back = out * turn * tool_pitch_radius / gear_pitch_radius;
                t.is_finite().then(|| (rotated([turned[0], turned[1] + centre], back), -back))
            }
        }
    }
}

/// Counterclockwise by `turn`.
fn rotated([x, y]: [f64; 2], turn: f64) -> [f64; 2] {
    let (sin, cos) = turn.sin_cos();
    [x * cos - y * sin, x * sin + y * cos]
}

/// The gear turns so far while the tool passes that its contacts would not be near each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "more than {MOST_BETWEEN} points would be needed between those of the tool, since the gear turns too far from one \
     contact to the next: give a larger pitch radius, a narrower range of radii or a shorter tool"
)]
pub struct TooManyBetween;

/// Places that a profile's points touch, in the profile's order.
#[derive(Clone, Debug, PartialEq)]
pub struct Envelope {
    /// Between two points of one branch the envelope goes on; where no point is touched a new
    /// branch begins.
    pub branches: Vec<Vec<Polar>>,
}

impl Envelope {
    /// Everything that `profile` touches under `motion` within radii from `least` to `most`.
    ///
    /// Where two neighbouring points of the tool touch far from each other, points and normals
    /// between them are tried too; refused where they would be more than [`MOST_BETWEEN`].
    ///
    /// ```
    /// use flankfit_gear::generation::envelope::{Envelope, Motion, ToolProfile};
    /// use std::f64::consts::{FRAC_PI_4, PI};
    ///
    /// // The straight flank of a rack of module 1, at 20°, cuts 30 teeth: on the pitch circle half
    /// // a tooth is a quarter of the pitch angle.
    /// let slope = 20_f64.to_radians().tan();
    /// let rack = [[-FRAC_PI_4 - slope, -1.0], [-FRAC_PI_4 + slope, 1.0]];
    /// let tool = ToolProfile::polyline(&rack, 200)?;
    /// let envelope = Envelope::of(&tool, Motion::Rack { pitch_radius: 15.0 }, [14.5, 16.0])?;
    /// let half_angle = envelope.boundary(&[15.0])[0].unwrap();
    /// assert!((half_angle - PI / 60.0).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(profile: &ToolProfile, motion: Motion, [least, most]: [f64; 2]) -> Result<Self, TooManyBetween> {
        let near = RESOLUTION * (most - least);
        let (range, branches, left) = (least..=most, vec![Vec::new()], MOST_BETWEEN);
        let mut trail = Trail { motion, range, near, branches, last: None, left };
        let mut before: Option<ToolPoint> = None;
        for tool in profile.points().iter().asking(200) {
            let tool = tool.towards(before.as_ref());
            if let Some(before) = before {
                trail.between(&before, &tool, DEEPEST)?;
            }
            trail.touch(motion.contact(&tool));
            before = Some(tool);
        }
        trail.branches.retain(|branch| branch.len() > 1);
        Ok(Envelope { branches: trail.branches })
    }

    /// The flank that is left, at ascending radii: half the tooth's angle, `None` where nothing of
    /// the tool passes.
    ///
    /// Between two points of a branch the angle is linear in the radius: the error falls with the
    /// square of their distance.
    pub fn boundary(&self, radii: &[f64]) -> Vec<Option<f64>> {
        let mut least: Vec<Option<f64>> = vec![None; radii.len()];
        for pair in self.branches.iter().flat_map(|branch| branch.windows(2)).asking(2000) {
            let (a, b) = if pair[0].radius <= pair[1].radius { (pair[0], pair[1]) } else { (pair[1], pair[0]) };
            let from = radii.partition_point(|radius| *radius < a.radius);
            for (radius, least) in radii[from..].iter().zip(&mut least[from..]).take_while(|(r, _)| **r <= b.radius) {
                let width = b.radius - a.radius;
                let share = if width > 0.0 { (radius - a.radius) / width } else { 0.0 };
                let angle = a.half_angle + share * (b.half_angle - a.half_angle);
                if least.is_none_or(|known| angle < known) {
                    *least = Some(angle);
                }
            }
        }
        least
    }
}

/// The envelope in the making.
struct Trail {
    motion: Motion,
    range: std::ops::RangeInclusive<f64>,
    near: f64,
    branches: Vec<Vec<Polar>>,
    last: Option<Polar>,
    /// How many more points may be tried between those of the profile.
    left: usize,
}

impl Trail {
    /// Takes points between `a` and `b` as long as these touch far from each other within the
    /// range.
    fn between(&mut self, a: &ToolPoint, b: &ToolPoint, depth: usize) -> Result<(), TooManyBetween> {
        let ends = [a, b].map(|tool| self.motion.contact_and_turn(tool));
        let seen = ends.iter().flatten().any(|([x, y], _)| self.range.contains(&x.hypot(*y)));
        // A normal along the pitch line never touches, but its neighbours do, ever farther out; on
        // both sides of it contacts may lie at one place, at instants far from each other.
        let far = match ends {
            [Some(([ax, ay], a)), Some(([bx, by], b))] => {
                (ax - bx).hypot(ay - by).max((a - b).abs() * ax.hypot(ay)) > self.near
            }
            _ => true,
        };
        if depth > 0 && seen && far {
            self.left = self.left.checked_sub(1).ok_or(TooManyBetween)?;
            let middle = a.half_way(b);
            self.between(a, &middle, depth - 1)?;
            self.touch(self.motion.contact(&middle));
            self.between(&middle, b, depth - 1)?;
        }
        Ok(())
    }

    fn touch(&mut self, contact: Option<[f64; 2]>) {
        let touched = contact.map(|[x, y]| Polar::of(x, y));
        let within = touched.filter(|polar| self.range.contains(&polar.radius));
        match (within, self.branches.last_mut()) {
            (Some(polar), Some(branch)) => {
                // The first point on the way in, and the last on the way out, lie just outside the
                // border.
                if branch.is_empty() {
                    branch.extend(self.last);
                }
                branch.push(polar);
            }
            (None, Some(branch)) if !branch.is_empty() => {
                branch.extend(touched);
                self.branches.push(Vec::new());
            }
            _ => {}
        }
        self.last = touched;
    }
}
