//! What any cutting profile leaves: the envelope by the meshing condition, computed point by point.
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

use std::f64::consts::PI;

use super::{
    Polar,
    fault::{MOST_BETWEEN, MOST_POINTS, ToolFaults, ToolField, ToolReason},
};
use crate::geometry::{
    curve::{Curve, Ends, cubic_spline},
    space::{Dimension, Vector},
};
use crate::numerics::cancel::Asking;

/// Most radii at which the flank that is left is asked for.
pub const MOST_RADII: usize = 10_000;

/// Between the two normals of a corner, one for each of these angles, rad.
const CORNER_STEP: f64 = 0.01;

/// Points that touch farther from each other than this part of the range get others in between …
const RESOLUTION: f64 = 1e-3;
/// … by halving at most so often.
const DEEPEST: usize = 24;

/// How tool and gear move, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// A rack whose pitch line rolls on the gear's circle of this radius.
    Rack {
        /// Radius of the gear's pitch circle.
        pitch_radius: f64,
    },
    /// Two pitch circles that roll on each other, the tool's inside the gear's where it is
    /// internal.
    Pinion {
        /// Radius of the tool's pitch circle.
        tool_pitch_radius: f64,
        /// Radius of the gear's pitch circle.
        gear_pitch_radius: f64,
        /// Whether the gear is internal.
        internal: bool,
    },
}

/// A point of a tool with the direction of its normal, either way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolPoint {
    /// Position in the tool, mm.
    pub point: [f64; 2],
    /// Direction of the normal, of any length above 0.
    pub normal: [f64; 2],
}

/// A tool's profile in the order of its points, from its tip along one flank.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolProfile {
    points: Vec<ToolPoint>,
}

impl ToolProfile {
    /// How many points a profile through so many, each interval in so many parts, may have: those
    /// of its corners come beside.
    pub fn most_points(points: usize, parts: usize) -> usize {
        let corner = (PI / CORNER_STEP) as usize + 1;
        points.saturating_mul(parts.saturating_add(corner)).min(MOST_POINTS)
    }

    /// Straight from point to point, each part taken in `parts` steps; corners are rounded by
    /// nothing, their normals turn.
    pub fn polyline(points: &[[f64; 2]], parts: usize) -> Result<Self, ToolFaults> {
        check(points, parts)?;
        let mut made: Vec<ToolPoint> = Vec::with_capacity((points.len() - 1) * (parts + 1));
        let mut before: Option<f64> = None;
        for pair in points.windows(2) {
            let [dx, dy] = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
            let direction = dy.atan2(dx);
            if let Some(before) = before {
                let turn = (direction - before + PI).rem_euclid(2.0 * PI) - PI;
                let steps = (turn.abs() / CORNER_STEP).ceil();
                if made.len() + steps as usize + parts > MOST_POINTS {
                    return Err(ToolFaults::one(ToolField::Points, ToolReason::Corners(parts)));
                }
                made.extend((1..steps as usize).map(|k| {
                    let (sin, cos) = (before + turn * k as f64 / steps).sin_cos();
                    ToolPoint { point: pair[0], normal: [sin, -cos] }
                }));
            }
            let normal = [dy, -dx];
            made.extend((0..=parts).map(|k| {
                let t = k as f64 / parts as f64;
                ToolPoint { point: [pair[0][0] + t * dx, pair[0][1] + t * dy], normal }
            }));
            before = Some(direction);
        }
        Ok(ToolProfile { points: made })
    }

    /// Smoothly through the points by a cubic spline over the chord length, each interval taken in
    /// `parts` steps.
    pub fn spline(points: &[[f64; 2]], parts: usize) -> Result<Self, ToolFaults> {
        check(points, parts)?;
        let mut along = vec![0.0; points.len()];
        for k in 1..points.len() {
            along[k] = along[k - 1] + (points[k][0] - points[k - 1][0]).hypot(points[k][1] - points[k - 1][1]);
        }
        let values: Vec<Vector> = points.iter().map(|[x, y]| Vector::new(*x, *y, 0.0)).collect();
        let curve = cubic_spline(Dimension::Plane, &along, &values, &Ends::not_a_knot())
            .map_err(|fault| ToolFaults::one(ToolField::Points, fault))?;
        let made = along.windows(2).enumerate().flat_map(|(k, pair)| {
            let (curve, first) = (&curve, usize::from(k > 0));
            let at = move |i: usize| pair[0] + (pair[1] - pair[0]) * i as f64 / parts as f64;
            (first..=parts).map(move |i| {
                let [value, slope, ..] = curve.jet(at(i));
                ToolPoint { point: [value.x, value.y], normal: [slope.y, -slope.x] }
            })
        });
        Ok(ToolProfile { points: made.collect() })
    }

    /// Points with normals of the caller's own.
    pub fn with_normals(points: Vec<ToolPoint>) -> Result<Self, ToolFaults> {
        let mut faults = ToolFaults::default();
        if points.len() > MOST_POINTS {
            faults.push(ToolField::Points, ToolReason::TooMany(points.len()));
        }
        for (index, tool) in points.iter().enumerate() {
            let finite = tool.point.iter().chain(&tool.normal).all(|x| x.abs() <= 1e6);
            if !finite || tool.normal == [0.0; 2] {
                faults.push(ToolField::Point { index }, ToolReason::NoDirection);
            }
        }
        faults.into_result(ToolProfile { points })
    }

    /// What the profile consists of.
    pub fn points(&self) -> &[ToolPoint] {
        &self.points
    }
}

fn check(points: &[[f64; 2]], parts: usize) -> Result<(), ToolFaults> {
    let mut faults = ToolFaults::default();
    if points.len() < 2 || parts == 0 {
        faults.push(ToolField::Points, ToolReason::TooFew(points.len()));
    }
    if points.len().saturating_mul(parts) > MOST_POINTS {
        faults.push(ToolField::Points, ToolReason::TooManyParts { points: points.len(), parts });
    }
    for (index, point) in points.iter().enumerate() {
        if let Some(x) = point.iter().find(|x| !(x.abs() <= 1e6)) {
            faults.push(ToolField::Point { index }, ToolReason::NoPlace(*x));
        } else if index > 0 && *point == points[index - 1] {
            faults.push(ToolField::Point { index }, ToolReason::Repeated);
        }
    }
    faults.into_result(())
}

impl Motion {
    /// Where a tool's point cuts, in the gear's frame; `None` where its normal never meets the
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
    "more than {MOST_BETWEEN} points would be tried between those of the tool, for the gear turns too far from one \
     contact to the \
     next: give a larger pitch radius, a narrower range of radii or a shorter tool"
)]
pub struct TooManyBetween;

/// What a profile's points touch, in the profile's order.
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
    /// use flankfit_engine::gear::generation::envelope::{Envelope, Motion, ToolProfile};
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
        for tool in profile.points.iter().asking(200) {
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

impl ToolPoint {
    /// The same with a normal of length 1, on the side that `before` has it on.
    fn towards(&self, before: Option<&ToolPoint>) -> Self {
        let [x, y] = self.normal;
        let against = before.is_some_and(|before| before.normal[0] * x + before.normal[1] * y < 0.0);
        let length = if against { -x.hypot(y) } else { x.hypot(y) };
        ToolPoint { point: self.point, normal: [x / length, y / length] }
    }

    /// Half way to another one.
    fn half_way(&self, other: &ToolPoint) -> Self {
        let middle = |a: [f64; 2], b: [f64; 2]| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        let between = ToolPoint { point: middle(self.point, other.point), normal: middle(self.normal, other.normal) };
        between.towards(Some(self))
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
                // The first point on the way in, and the last on the way out, lie just beyond the
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
