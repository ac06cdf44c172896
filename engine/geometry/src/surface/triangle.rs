//! Patches of three sides: four-sided ones, one border of which is a point (the paper's degenerated
//! case of section 2.1).
//!
//! At the tip the parameter along the collapsed border moves nothing, S_u = 0 say, and the formulas
//! for normal and curvature read 0/0. Along any one line into the tip they may have a limit, found
//! by extrapolating from a few places on it.

use super::{
    Surface, SurfaceJet,
    boundaries::Border,
    differential::{BLUNT, Differential, is_singular, symmetric_eigen},
};
use crate::space::{Dimension, Vector};
use nalgebra::Matrix3;

/// A border that is a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DegenerateBorder {
    /// Which border it is.
    pub border: Border,
    /// The point.
    pub point: Vector,
    /// How far the border's points are from it, at most.
    pub extent: f64,
}

/// How many places are looked at between two breaks of a border.
const LOOKS: usize = 8;

/// The borders whose points all lie within `tolerance` of their first. A surface z(u, v) has none.
pub fn degenerate_borders(surface: &dyn Surface, tolerance: f64) -> Vec<DegenerateBorder> {
    if surface.dimension() != Dimension::Space {
        return Vec::new();
    }
    let (domain, breaks) = (surface.domain(), surface.breaks());
    let extent_of = |border: Border| {
        let breaks = &breaks[border.axis()];
        let at = |t: f64| {
            let (u, v) = border.place(domain, t);
            surface.value(u, v)
        };
        let point = at(breaks[0]);
        let spans = breaks.windows(2).flat_map(|w| (1..=LOOKS).map(move |k| (w[0], w[1], k as f64 / LOOKS as f64)));
        let extent = spans.map(|(a, b, s)| (at(a + s * (b - a)) - point).norm()).fold(0.0, f64::max);
        DegenerateBorder { border, point, extent }
    };
    Border::ALL.into_iter().map(extent_of).filter(|found| found.extent <= tolerance).collect()
}

/// Distances from the singular place, as shares of the span that lies there: the first, halved this
/// many times.
const FIRST: f64 = 1.0 / 16.0;
const HALVINGS: usize = 7;
/// Successive extrapolations that differ by more, relative to their size, do not converge.
const SETTLED: f64 = 1e-4;

/// The limit of the unit normal along the parameter line that leaves the singular place (u, v) into
/// the patch.
pub(super) fn normal_limit(surface: &dyn Surface, u: f64, v: f64) -> Option<Vector> {
    of_normals(&approach(surface, u, v)?, SETTLED)
}

fn of_normals(samples: &[Differential], settled: f64) -> Option<Vector> {
    let normals = samples.iter().map(|near| near.normal.into()).collect();
    Vector::from(extrapolated::<3>(normals, settled)?).try_normalize(0.5)
}

/// The limit of everything in [`Differential`] along that line. `None` if it does not converge (if
/// the lines that run into the tip lie in no plane, the patch ends there as a cone does, and its
/// curvature grows without bound), or if it is not known to better than the relative `error`.
pub(super) fn limit(surface: &dyn Surface, u: f64, v: f64, error: f64) -> Option<Differential> {
    let settled = SETTLED.min(error);
    let here = surface.place(u, v);
    let samples = approach(surface, u, v)?;
    let normal = of_normals(&samples, settled)?;
    // the shape operator as a tensor of space is smooth even where its directions are not
    let tensors = samples.iter().map(|near| {
        let [d1, d2] = near.directions;
        let shape = d1 * d1.transpose() * near.principal[0] + d2 * d2.transpose() * near.principal[1];
        [shape.m11, shape.m22, shape.m33, shape.m12, shape.m13, shape.m23]
    });
    let [m11, m22, m33, m12, m13, m23] = extrapolated(tensors.collect(), settled)?;
    let shape = Matrix3::new(m11, m12, m13, m12, m22, m23, m13, m23, m33);
    let e1 = across(&normal);
    let e2 = normal.cross(&e1);
    let (s11, s12, s22) = (e1.dot(&(shape * e1)), e1.dot(&(shape * e2)), e2.dot(&(shape * e2)));
    let (principal, [p, q]) = symmetric_eigen(s11, s12, s22);
    let first = e1 * p + e2 * q;
    Some(Differential {
        point: here.value,
        normal,
        first_form: [here.u.norm_squared(), here.u.dot(&here.v), here.v.norm_squared()],
        second_form: [normal.dot(&here.uu), normal.dot(&here.uv), normal.dot(&here.vv)],
        gaussian: s11 * s22 - s12 * s12,
        mean: 0.5 * (s11 + s22),
        principal,
        directions: [first, normal.cross(&first)],
        by_limit: true,
    })
}

/// Local geometry from a few places ever nearer to (u, v); `None` if these are singular
/// too.
fn approach(surface: &dyn Surface, u: f64, v: f64) -> Option<Vec<Differential>> {
    let [du, dv] = inward(surface, &surface.place(u, v), u, v);
    let near = |k: usize| {
        let h = FIRST * 0.5f64.powi(k as i32);
        let jet = surface.place(u + h * du, v + h * dv);
        if is_singular(&jet, surface.domain()) { None } else { Differential::of(&jet) }
    };
    (0..=HALVINGS).map(near).collect()
}

/// A step from (u, v) across the span that lies there, along the parameter that moves the point, or
/// along both if neither does.
fn inward(surface: &dyn Surface, here: &SurfaceJet, u: f64, v: f64) -> [f64; 2] {
    let breaks = surface.breaks();
    let step = |axis: usize, x: f64| {
        let places = &breaks[axis];
        // into the longer part of the span around x, so that it leads away from what is singular at
        // an end
        let above = places.iter().find(|b| **b > x).map_or(0.0, |next| next - x);
        let below = places.iter().rev().find(|b| **b < x).map_or(0.0, |before| before - x);
        if above >= -below { above } else { below }
    };
    let (du, dv) = (step(0, u), step(1, v));
    let (moved_u, moved_v) = (here.u.norm() * du.abs(), here.v.norm() * dv.abs());
    if moved_u <= BLUNT * moved_v {
        [0.0, dv]
    } else if moved_v <= BLUNT * moved_u {
        [du, 0.0]
    } else {
        [du, dv]
    }
}

/// Returns Neville's extrapolation to 0 of samples at 1, 1/2, 1/4, …; `None` unless the last two
/// agree to within `settled`, relative to their size.
fn extrapolated<const N: usize>(mut table: Vec<[f64; N]>, settled: f64) -> Option<[f64; N]> {
    let mut before = *table.last()?;
    for order in 1..table.len() {
        let factor = 2f64.powi(order as i32) - 1.0;
        before = *table.last()?;
        for i in (order..table.len()).rev() {
            for k in 0..N {
                table[i][k] += (table[i][k] - table[i - 1][k]) / factor;
            }
        }
    }
    let last = *table.last()?;
    let size = last.iter().fold(0.0f64, |a, x| a.max(x.abs()));
    let change = last.iter().zip(before).fold(0.0f64, |a, (x, y)| a.max((x - y).abs()));
    (size.is_finite() && change <= settled * size).then_some(last)
}

/// A unit vector at right angles to `n`.
fn across(n: &Vector) -> Vector {
    let least = n.iamin();
    let mut axis = Vector::zeros();
    axis[least] = 1.0;
    n.cross(&axis).normalize()
}
