//! Arithmetic of jets: how products of functions of u and of v, and sums of them, pass on to
//! derivatives of order 2.

use super::SurfaceJet;
use crate::space::Vector;

/// Value and derivatives of a number over (u, v): value, u, v, uu, uv, vv.
pub(super) type NumberJet = [f64; 6];

/// Value, first and second derivative of a number over one parameter.
pub(super) type Blend = [f64; 3];

/// The jet of `a(u) b(v)`.
pub(super) fn product(a: Blend, b: Blend) -> NumberJet {
    [a[0] * b[0], a[1] * b[0], a[0] * b[1], a[2] * b[0], a[1] * b[1], a[0] * b[2]]
}

impl SurfaceJet {
    /// The jet of the surface that is 0 everywhere.
    pub(super) fn zero() -> Self {
        let zero = Vector::zeros();
        SurfaceJet { value: zero, u: zero, v: zero, uu: zero, uv: zero, vv: zero }
    }

    /// Adds `point · share(u, v)`.
    pub(super) fn add(&mut self, point: &Vector, share: &NumberJet) {
        self.value += point * share[0];
        self.u += point * share[1];
        self.v += point * share[2];
        self.uu += point * share[3];
        self.uv += point * share[4];
        self.vv += point * share[5];
    }

    /// Adds `blend(u) · curve(v)`, the curve with its derivatives by v.
    pub(super) fn add_over_v(&mut self, blend: Blend, curve: &[Vector; 3]) {
        self.value += curve[0] * blend[0];
        self.u += curve[0] * blend[1];
        self.v += curve[1] * blend[0];
        self.uu += curve[0] * blend[2];
        self.uv += curve[1] * blend[1];
        self.vv += curve[2] * blend[0];
    }

    /// The same surface over (v, u).
    pub(super) fn swapped(self) -> Self {
        SurfaceJet { value: self.value, u: self.v, v: self.u, uu: self.vv, uv: self.uv, vv: self.uu }
    }

    /// Adds `blend(v) · curve(u)`, the curve with its derivatives by u.
    pub(super) fn add_over_u(&mut self, blend: Blend, curve: &[Vector; 3]) {
        let mut swapped = self.swapped();
        swapped.add_over_v(blend, curve);
        *self = swapped.swapped();
    }

    /// The jet by parameters of which these are `factors` times the rate: the chain rule of an
    /// affine map.
    pub(super) fn scaled(mut self, factors: [f64; 2]) -> Self {
        let [a, b] = factors;
        self.u *= a;
        self.v *= b;
        self.uu *= a * a;
        self.uv *= a * b;
        self.vv *= b * b;
        self
    }
}
