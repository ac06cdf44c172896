//! A rectangle of parameters, and bounds of the distances to all of it from its middle.
//!
//! With bounds of the second derivatives Taylor's formula encloses the part of the surface: it lies
//! within `rest` of the parallelogram that the tangents at the middle span.

use super::{Surface, SurfaceJet, bends::Bends};
use crate::space::Vector;

/// A part of a smooth piece of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub middle: [f64; 2],
    /// Half the sides.
    pub half: [f64; 2],
    /// Bounds of the second derivatives in it.
    pub bends: Bends,
    /// The jet of the place in space of its middle.
    pub jet: SurfaceJet,
}

impl Cell {
    pub(crate) fn new(surface: &dyn Surface, u: [f64; 2], v: [f64; 2], bends: Bends) -> Self {
        let middle = [u, v].map(|[low, high]| 0.5 * low + 0.5 * high);
        let half = [u, v].map(|[low, high]| 0.5 * (high - low));
        Cell { middle, half, bends, jet: surface.place(middle[0], middle[1]) }
    }

    /// The parameters it covers.
    pub(crate) fn sides(&self) -> [[f64; 2]; 2] {
        [0, 1].map(|k| [self.middle[k] - self.half[k], self.middle[k] + self.half[k]])
    }

    /// How far a place of it may be from the parallelogram.
    fn rest(&self) -> f64 {
        let ([a, b], [uu, uv, vv]) = (self.half, self.bends);
        0.5 * (uu * a * a + 2.0 * uv * a * b + vv * b * b)
    }

    /// How far a place of it may be from its middle.
    pub(crate) fn radius(&self) -> f64 {
        let (u, v) = (self.jet.u * self.half[0], self.jet.v * self.half[1]);
        (u + v).norm().max((u - v).norm()) + self.rest()
    }

    /// No place of it is nearer to `node` than this.
    pub(crate) fn bound(&self, node: &Vector) -> f64 {
        (self.off_parallelogram(node) - self.rest()).max(0.0)
    }

    fn off_parallelogram(&self, node: &Vector) -> f64 {
        let (u, v) = (self.jet.u * self.half[0], self.jet.v * self.half[1]);
        let rest = node - self.jet.value;
        let (a, b, c) = (u.norm_squared(), u.dot(&v), v.norm_squared());
        let (ru, rv) = (rest.dot(&u), rest.dot(&v));
        let determinant = a * c - b * b;
        if determinant > 1e-12 * a * c {
            let (x, y) = ((c * ru - b * rv) / determinant, (a * rv - b * ru) / determinant);
            if x.abs() <= 1.0 && y.abs() <= 1.0 {
                return (rest - u * x - v * y).norm();
            }
        }
        // the foot is on a side: a flat function of one variable each
        let along = |side: Vector, direction: &Vector, size: f64| {
            let place = if size > 0.0 { (side.dot(direction) / size).clamp(-1.0, 1.0) } else { 0.0 };
            (side - direction * place).norm()
        };
        let sides = [along(rest - u, &v, c), along(rest + u, &v, c), along(rest - v, &u, a), along(rest + v, &u, a)];
        sides.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Whether the squared distance to `node` is surely a convex function of the parameters in it,
    /// so that its least value is found by going downhill.
    pub(crate) fn is_convex(&self, node: &Vector) -> bool {
        let ([a, b], [uu, uv, vv]) = (self.half, self.bends);
        let (long_u, long_v) = (self.jet.u.norm(), self.jet.v.norm());
        // by how much the tangents change, and how far a place is from the node at most
        let (change_u, change_v) = (uu * a + uv * b, uv * a + vv * b);
        let far = (self.jet.value - node).norm() + self.radius();
        let hu = (long_u - change_u).max(0.0).powi(2) - far * uu;
        let hv = (long_v - change_v).max(0.0).powi(2) - far * vv;
        let mixed =
            self.jet.u.dot(&self.jet.v).abs() + long_u * change_v + long_v * change_u + change_u * change_v + far * uv;
        hu > 0.0 && hv > 0.0 && hu * hv > mixed * mixed
    }

    /// Its halves across the longer way; `None` where the parameters are no longer distinguishable.
    pub(crate) fn halves(&self, surface: &dyn Surface) -> Option<[Cell; 2]> {
        let long = |k: usize, tangent: &Vector, bend: f64| {
            self.half[k] * (tangent.norm() + bend * self.half[k] + self.bends[1] * self.half[1 - k])
        };
        let along_u = long(0, &self.jet.u, self.bends[0]) >= long(1, &self.jet.v, self.bends[2]);
        let [u, v] = self.sides();
        let axis = if along_u { 0 } else { 1 };
        let ([low, high], middle) = ([u, v][axis], self.middle[axis]);
        if !(low < middle && middle < high) {
            return None;
        }
        let part = |side: [f64; 2]| {
            let [u, v] = if along_u { [side, v] } else { [u, side] };
            Cell::new(surface, u, v, self.bends)
        };
        Some([part([low, middle]), part([middle, high])])
    }
}
