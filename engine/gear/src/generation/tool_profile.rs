//! A tool's transverse profile as points with normals.

use std::f64::consts::PI;

use flankfit_geometry::{
    curve::{Curve, Ends, cubic_spline},
    space::{Dimension, Vector},
};
use flankfit_numerics::{
    check::Faults,
    words::{Shown, counted},
};

/// Most points of a profile, those of its steps and corners with them.
pub const MOST_POINTS: usize = 200_000;

/// Between the two normals of a corner, one for each of these angles, rad.
const CORNER_STEP: f64 = 0.01;

/// A point of a tool with the direction of its normal, either way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolPoint {
    /// Position in the tool, mm.
    pub point: [f64; 2],
    /// Direction of the normal, of any length above 0.
    pub normal: [f64; 2],
}

impl ToolPoint {
    /// The same with a normal of length 1, on the side that `before` has it on.
    pub(super) fn towards(&self, before: Option<&ToolPoint>) -> Self {
        let [x, y] = self.normal;
        let against = before.is_some_and(|before| before.normal[0] * x + before.normal[1] * y < 0.0);
        let length = if against { -x.hypot(y) } else { x.hypot(y) };
        ToolPoint { point: self.point, normal: [x / length, y / length] }
    }

    /// Half way to another one.
    pub(super) fn half_way(&self, other: &ToolPoint) -> Self {
        let middle = |a: [f64; 2], b: [f64; 2]| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        let between = ToolPoint { point: middle(self.point, other.point), normal: middle(self.normal, other.normal) };
        between.towards(Some(self))
    }
}

/// A tool's profile in the order of its points, from its tip along one flank.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolProfile {
    points: Vec<ToolPoint>,
}

impl ToolProfile {
    /// How many points a profile through so many, each interval in so many parts, may have: those
    /// of its corners are added.
    pub fn most_points(points: usize, parts: usize) -> usize {
        let corner = (PI / CORNER_STEP) as usize + 1;
        points.saturating_mul(parts.saturating_add(corner)).min(MOST_POINTS)
    }

    /// Straight from point to point, each part taken in `parts` steps; corners are rounded by
    /// nothing, their normals turn.
    pub fn polyline(points: &[[f64; 2]], parts: usize) -> Result<Self, Faults> {
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
                    return Err(Faults::one(
                        "",
                        format_args!(
                            "with the normals at their corners these points in {parts} parts each are more than \
                             {MOST_POINTS}: give fewer points or parts, or join them by a spline"
                        ),
                    ));
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
    pub fn spline(points: &[[f64; 2]], parts: usize) -> Result<Self, Faults> {
        check(points, parts)?;
        let mut along = vec![0.0; points.len()];
        for k in 1..points.len() {
            along[k] = along[k - 1] + (points[k][0] - points[k - 1][0]).hypot(points[k][1] - points[k - 1][1]);
        }
        let values: Vec<Vector> = points.iter().map(|[x, y]| Vector::new(*x, *y, 0.0)).collect();
        let curve = cubic_spline(Dimension::Plane, &along, &values, &Ends::not_a_knot())
            .map_err(|found| Faults::one("", &found.list()[0].message))?;
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

    /// Points that the profile consists of.
    pub fn points(&self) -> &[ToolPoint] {
        &self.points
    }
}

fn check(points: &[[f64; 2]], parts: usize) -> Result<(), Faults> {
    let mut faults = Faults::default();
    if points.len() < 2 || parts == 0 {
        let points = counted(points.len(), "point", "points");
        faults.push("", format_args!("{points}; a profile has at least 2"));
    }
    if points.len().saturating_mul(parts) > MOST_POINTS {
        let points = points.len();
        faults.push("", format_args!("{points} points in {parts} parts each; at most {MOST_POINTS} in all"));
    }
    for (index, point) in points.iter().enumerate() {
        if let Some(x) = point.iter().find(|x| !(x.abs() <= 1e6)) {
            faults.push(format_args!("[{index}]"), format_args!("{} is not a place on a tool, in mm", Shown(*x)));
        } else if index > 0 && *point == points[index - 1] {
            faults.push(format_args!("[{index}]"), "the same point as the one before it");
        }
    }
    faults.into_result(())
}
