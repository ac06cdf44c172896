//! Any surface as B-spline surfaces, which is what CAD reads.
//!
//! Exact where that exists: Bézier patches, Coons patches of polynomial boundary curves (their
//! blends are polynomials too), Gregory patches whose pairs coincide. What is rational in another
//! way is approached by bicubic interpolation, ever finer until it is within a tolerance. A surface
//! of several pieces becomes several, since CAD takes a patch for smooth.

use super::{
    BSplineSurface, CoonsPatch, GregoryPatch, NodeGrid, Surface, SurfaceShape, bezier::one_span, boundaries::CORNERS,
    interpolate::interpolate,
};
use crate::{
    BSplineBasis,
    curve::{BSplineCurve, Curve, CurveShape},
    space::{Dimension, Vector},
};
use flankfit_numerics::cancel;

/// Spans of an approximation along each parameter, at first and at most.
const FIRST: usize = 8;
const MOST: usize = 128;

/// A B-spline surface that represents a surface or a part of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Converted {
    /// The B-spline or NURBS surface.
    pub surface: BSplineSurface,
    /// The largest distance from what it represents, at equal parameters; 0 where it is the
    /// same function.
    pub deviation: f64,
}

impl SurfaceShape {
    /// B-spline surfaces that are together this surface: the same functions where that is possible,
    /// else within `tolerance` (in units of the coordinates) or as near as 128 × 128 spans come.
    /// `deviation` says how near that is.
    ///
    /// ```
    /// use flankfit_geometry::{
    ///     space::{Dimension, Vector},
    ///     surface::{BezierSurface, SurfaceShape},
    /// };
    ///
    /// // A Bézier patch is a B-spline surface of one span, exactly.
    /// let heights = [0.0, 0.0, 0.0, 1.0].map(|z| Vector::new(z, 0.0, 0.0)).to_vec();
    /// let patch = BezierSurface::new([2, 2], [[0.0, 1.0]; 2], Dimension::Graph, heights, None)?;
    /// let splines = SurfaceShape::Bezier(patch).to_b_splines(1e-6);
    /// assert_eq!((splines.len(), splines[0].deviation), (1, 0.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn to_b_splines(&self, tolerance: f64) -> Vec<Converted> {
        let exact = |surface: BSplineSurface| vec![Converted { surface, deviation: 0.0 }];
        match self {
            SurfaceShape::BSpline(surface) => exact(surface.clone()),
            SurfaceShape::Bezier(patch) => exact(patch.as_b_spline().clone()),
            SurfaceShape::Coons(patch) => match patch.to_b_spline() {
                Some(surface) => exact(surface),
                None => approached(patch.as_ref(), !patch.has_one_twist_at_each_corner(), tolerance),
            },
            SurfaceShape::Gregory(patch) => match patch.to_b_spline() {
                Some(surface) => exact(surface),
                None => approached(patch.as_ref(), true, tolerance),
            },
            SurfaceShape::Patchwork(work) => {
                work.patches().iter().flat_map(|patch| patch.to_b_splines(tolerance)).collect()
            }
        }
    }
}

impl GregoryPatch {
    /// The same surface, where it is a Bézier patch.
    pub(super) fn to_b_spline(&self) -> Option<BSplineSurface> {
        if !self.is_polynomial() {
            return None;
        }
        let [u, v] = self.domain();
        let bases = [one_span(3, u).ok()?, one_span(3, v).ok()?];
        BSplineSurface::new(bases, self.dimension(), self.points().net.concat(), None).ok()
    }
}

/// One axis of a Coons patch: the basis that all curves over it and all blends fit into.
struct Side {
    basis: BSplineBasis,
    /// Control points of the two curves over this axis, and of the derivatives across them.
    curves: [Vec<Vector>; 2],
    cross: Option<[Vec<Vector>; 2]>,
    /// Coefficients of the blends of values and of derivatives at the axis' lower and upper end.
    values: [Vec<f64>; 2],
    slopes: Option<[Vec<f64>; 2]>,
}

impl CoonsPatch {
    /// The same surface, where all curves are polynomials and each corner has one twist.
    pub(super) fn to_b_spline(&self) -> Option<BSplineSurface> {
        if !self.has_one_twist_at_each_corner() {
            return None;
        }
        let [u, v] = [side(self, 0)?, side(self, 1)?];
        let corner = |i: usize, j: usize| self.boundaries().corner(i, j);
        let mut points = Vec::with_capacity(u.basis.size() * v.basis.size());
        for k in 0..u.basis.size() {
            cancel::checkpoint();
            for l in 0..v.basis.size() {
                let mut sum = Vector::zeros();
                for end in 0..2 {
                    sum += v.curves[end][l] * u.values[end][k] + u.curves[end][k] * v.values[end][l];
                }
                for (i, j) in CORNERS {
                    sum -= corner(i, j) * (u.values[i][k] * v.values[j][l]);
                }
                if let (Some(slopes_u), Some(slopes_v), Some(cross_u), Some(cross_v)) =
                    (&u.slopes, &v.slopes, &u.cross, &v.cross)
                {
                    for end in 0..2 {
                        sum += cross_v[end][l] * slopes_u[end][k] + cross_u[end][k] * slopes_v[end][l];
                    }
                    for (i, j) in CORNERS {
                        let [along_u, along_v, twist] = self.corner_derivatives(i, j)?;
                        sum -= along_u * (slopes_u[i][k] * v.values[j][l]);
                        sum -= along_v * (u.values[i][k] * slopes_v[j][l]);
                        sum -= twist * (slopes_u[i][k] * slopes_v[j][l]);
                    }
                }
                points.push(sum);
            }
        }
        BSplineSurface::new([u.basis, v.basis], self.dimension(), points, None).ok()
    }
}

fn side(patch: &CoonsPatch, axis: usize) -> Option<Side> {
    let domain = patch.domain()[axis];
    // the curves over u are number 2 and 3
    let numbers = if axis == 0 { [2, 3] } else { [0, 1] };
    let on_domain = |curve: &CurveShape| mapped(curve, domain);
    let curves = numbers.map(|k| on_domain(&patch.boundaries().curves()[k]));
    let cross = patch.cross_derivatives().map(|cross| numbers.map(|k| on_domain(&cross[k])));
    let mut all: Vec<BSplineCurve> = curves.into_iter().chain(cross.into_iter().flatten()).collect::<Option<_>>()?;
    let blends = blends(domain, all.len() > 2)?;
    all.extend(blends);
    let degree = all.iter().map(|c| c.basis().degree()).max()?;
    let raised: Vec<BSplineCurve> =
        all.iter().map(|c| c.elevate(degree - c.basis().degree()).ok()).collect::<Option<_>>()?;
    let knots = common_knots(&raised);
    let basis = BSplineBasis::new(degree, knots.clone()).ok()?;
    let refined = raised.iter().map(|curve| curve.refine(&missing(&knots, curve.basis().knots())).ok());
    let mut nets = refined.collect::<Option<Vec<_>>>()?.into_iter().map(|c| c.control_points().to_vec());
    let mut pair = || Some([nets.next()?, nets.next()?]);
    let numbers = |pair: [Vec<Vector>; 2]| pair.map(|net| net.iter().map(|p| p.x).collect());
    let curves = pair()?;
    let cross = if patch.cross_derivatives().is_some() { Some(pair()?) } else { None };
    let values = numbers(pair()?);
    let slopes = if cross.is_some() { Some(numbers(pair()?)) } else { None };
    Some(Side { basis, curves, cross, values, slopes })
}

/// The curve as a polynomial B-spline over `domain`, clamped; none for a rational one.
fn mapped(curve: &CurveShape, [low, high]: [f64; 2]) -> Option<BSplineCurve> {
    let spline = curve.to_b_spline().ok()?.clamp().ok()?;
    if spline.weights().is_some() {
        return None;
    }
    let [a, b] = spline.domain();
    if [a, b] == [low, high] {
        return Some(spline);
    }
    let place = |t: &f64| {
        let share = (t - a) / (b - a);
        low * (1.0 - share) + high * share
    };
    let knots = spline.basis().knots().iter().map(place).collect();
    let basis = BSplineBasis::new(spline.basis().degree(), knots).ok()?;
    BSplineCurve::new(basis, spline.dimension(), spline.control_points().to_vec(), None).ok()
}

/// The blending functions of a Coons patch over `domain`: for the values, and for the slopes of a
/// bicubic one.
fn blends(domain: [f64; 2], bicubic: bool) -> Option<Vec<BSplineCurve>> {
    let third = (domain[1] - domain[0]) / 3.0;
    let tables: &[&[f64]] = if bicubic {
        &[&[1.0, 1.0, 0.0, 0.0], &[0.0, 0.0, 1.0, 1.0], &[0.0, third, 0.0, 0.0], &[0.0, 0.0, -third, 0.0]]
    } else {
        &[&[1.0, 0.0], &[0.0, 1.0]]
    };
    let curve = |table: &&[f64]| {
        let points = table.iter().map(|x| Vector::new(*x, 0.0, 0.0)).collect();
        BSplineCurve::new(one_span(table.len() - 1, domain).ok()?, Dimension::Graph, points, None).ok()
    };
    tables.iter().map(curve).collect()
}

/// Every knot as often as the curve that has it most often.
fn common_knots(curves: &[BSplineCurve]) -> Vec<f64> {
    let mut knots: Vec<f64> = Vec::new();
    for curve in curves {
        knots.extend(missing(curve.basis().knots(), &knots));
        knots.sort_by(f64::total_cmp);
    }
    knots
}

/// Entries that `wanted` has more often than `given`; both ascend.
fn missing(wanted: &[f64], given: &[f64]) -> Vec<f64> {
    let mut given = given.iter().peekable();
    let mut more = Vec::new();
    for knot in wanted {
        while given.next_if(|g| *g < knot).is_some() {}
        if given.next_if(|g| *g == knot).is_none() {
            more.push(*knot);
        }
    }
    more
}

/// Bicubic interpolants of the pieces between the breaks. Where corners have two twists each
/// (`graded`) second derivatives have no limit there, and those of order 4 grow as 1 / r²; nodes as
/// dense there as the root of r make the deviation alike everywhere.
fn approached(surface: &dyn Surface, graded: bool, tolerance: f64) -> Vec<Converted> {
    let [us, vs] = surface.breaks();
    let mut found = Vec::new();
    for u in us.windows(2) {
        for v in vs.windows(2) {
            found.extend(approached_piece(surface, [u[0], u[1]], [v[0], v[1]], graded, tolerance));
        }
    }
    found
}

fn approached_piece(
    surface: &dyn Surface,
    u: [f64; 2],
    v: [f64; 2],
    graded: bool,
    tolerance: f64,
) -> Option<Converted> {
    let places = |[low, high]: [f64; 2], n: usize| -> Vec<f64> {
        let share = |s: f64| if graded { s * s * (3.0 - 2.0 * s) } else { s };
        let at = |k: usize| if k == n { high } else { low + (high - low) * share(k as f64 / n as f64) };
        (0..=n).map(at).collect()
    };
    let mut spans = FIRST;
    loop {
        cancel::checkpoint();
        let (us, vs) = (places(u, spans), places(v, spans));
        let values: Vec<Vector> =
            us.iter().flat_map(|u| vs.iter().map(move |v| (*u, *v))).map(|(u, v)| surface.value(u, v)).collect();
        let grid = match surface.dimension() {
            Dimension::Graph => NodeGrid::heights(us, vs, &values.iter().map(|z| z.x).collect::<Vec<_>>()),
            _ => NodeGrid::points(us, vs, values),
        };
        let spline = interpolate(&grid.ok()?, [3, 3], [None, None]).ok()?;
        // between the nodes, where interpolants are furthest off
        let (us, vs) = (places(u, 2 * spans), places(v, 2 * spans));
        let off = |(u, v): (f64, f64)| (spline.value(u, v) - surface.value(u, v)).norm();
        let deviation = us.iter().flat_map(|u| vs.iter().map(move |v| (*u, *v))).map(off).fold(0.0, f64::max);
        if deviation <= tolerance || spans >= MOST {
            return Some(Converted { surface: spline, deviation });
        }
        spans *= 2;
    }
}
