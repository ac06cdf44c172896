//! Differential geometry at a point: normal, first and second fundamental form, curvatures and
//! their directions.
//!
//! The normal is S_u × S_v made unit; a curvature is above 0 where the surface bends towards it.
//! Curvatures are eigenvalues of the shape operator in an orthonormal frame of the tangent plane,
//! which keeps their digits where S_u and S_v are long or nearly parallel. Where S_u × S_v = 0, at
//! the tip of a three-sided patch, everything is a limit: see [`Differential::at`].

use super::SurfaceJet;
use crate::space::Vector;

/// Values of [`sharpness`] below which S_u and S_v determine no normal.
const SINGULAR: f64 = 1e-10;

/// Values of [`sharpness`] below which the formulas of a regular place lose more than half of the
/// digits of curvatures.
pub(super) const BLUNT: f64 = 1e-4;

/// Local geometry from the derivatives at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differential {
    /// The point S(u, v).
    pub point: Vector,
    /// Unit normal, along S_u × S_v.
    pub normal: Vector,
    /// E, F, G: products of S_u and S_v.
    pub first_form: [f64; 3],
    /// L, M, N: the normal's products with S_uu, S_uv, S_vv.
    pub second_form: [f64; 3],
    /// Product of the principal curvatures.
    pub gaussian: f64,
    /// Half the sum of the principal curvatures.
    pub mean: f64,
    /// The principal curvatures, the larger first.
    pub principal: [f64; 2],
    /// The unit tangents along which these are taken, at right angles. Where both are equal, any
    /// two are as good.
    pub directions: [Vector; 2],
    /// Whether the parameters are singular or nearly so here, so that all but `point` and
    /// `first_form` are limits along a line of parameters.
    pub by_limit: bool,
}

impl Differential {
    /// At a regular point, from the jet of the place in space (see
    /// [`Surface::place`](super::Surface::place)); `None` where S_u × S_v vanishes.
    pub fn of(jet: &SurfaceJet) -> Option<Self> {
        let across = jet.u.cross(&jet.v);
        let (long_u, long_cross) = (jet.u.norm(), across.norm());
        if !(long_u > 0.0 && long_cross > 0.0 && long_cross.is_finite()) {
            return None;
        }
        let normal = across / long_cross;
        let first_form = [jet.u.norm_squared(), jet.u.dot(&jet.v), jet.v.norm_squared()];
        let second_form = [normal.dot(&jet.uu), normal.dot(&jet.uv), normal.dot(&jet.vv)];
        // S_u = a e₁, S_v = b e₁ + c e₂; the shape operator in (e₁, e₂) is the second form between
        // the columns of the inverse
        let e1 = jet.u / long_u;
        let e2 = normal.cross(&e1);
        let (a, b, c) = (long_u, jet.v.dot(&e1), long_cross / long_u);
        let [l, m, n] = second_form;
        let s11 = l / (a * a);
        let s12 = (m - b * l / a) / (a * c);
        let s22 = ((n - b * m / a) - (b / a) * (m - b * l / a)) / (c * c);
        let (principal, [x, y]) = symmetric_eigen(s11, s12, s22);
        let first = e1 * x + e2 * y;
        Some(Differential {
            point: jet.value,
            normal,
            first_form,
            second_form,
            gaussian: s11 * s22 - s12 * s12,
            mean: 0.5 * (s11 + s22),
            principal,
            directions: [first, normal.cross(&first)],
            by_limit: false,
        })
    }
}

/// Whether S_u and S_v span no reliable plane.
pub(super) fn is_singular(jet: &SurfaceJet, domain: [[f64; 2]; 2]) -> bool {
    !(sharpness(jet, domain) > SINGULAR)
}

/// Returns how well S_u and S_v span a plane: small if one of them vanishes against its own change
/// over the patch, or if they are nearly parallel. Curvatures of a regular place have a relative
/// error of about ε over the square of this value.
pub(super) fn sharpness(jet: &SurfaceJet, [[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    let (wide, high) = (b - a, d - c);
    let size_u = jet.u.norm() + wide * jet.uu.norm() + high * jet.uv.norm();
    let size_v = jet.v.norm() + wide * jet.uv.norm() + high * jet.vv.norm();
    jet.u.cross(&jet.v).norm() / (size_u * size_v)
}

/// Eigenvalues of ((a, b), (b, c)), the larger first, and the unit eigenvector of that one.
pub(super) fn symmetric_eigen(a: f64, b: f64, c: f64) -> ([f64; 2], [f64; 2]) {
    let (middle, half) = (0.5 * (a + c), 0.5 * (a - c));
    let radius = half.hypot(b);
    let (mut high, mut low) = (middle + radius, middle - radius);
    // the one nearer 0 of the product, where subtraction would cost its digits
    let determinant = a * c - b * b;
    if middle > 0.0 {
        low = determinant / high;
    } else if middle < 0.0 {
        high = determinant / low;
    }
    // (A − low) has the eigenvector of `high` in both columns; the longer one is taken
    let (x, y) = if half >= 0.0 { (radius + half, b) } else { (b, radius - half) };
    let length = x.hypot(y);
    let vector = if length > 0.0 { [x / length, y / length] } else { [1.0, 0.0] };
    ([high, low], vector)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn eigenvalues_and_vector_of_a_symmetric_matrix(a in -9.0..9.0f64, b in -9.0..9.0f64, c in -9.0..9.0f64) {
            let ([high, low], [x, y]) = symmetric_eigen(a, b, c);
            prop_assert!(high >= low);
            prop_assert!((high + low - a - c).abs() < 1e-13 && (high * low - a * c + b * b).abs() < 1e-12);
            prop_assert!((a * x + b * y - high * x).abs() < 1e-13 && (b * x + c * y - high * y).abs() < 1e-13);
            prop_assert!((x.hypot(y) - 1.0).abs() < 1e-15);
        }
    }

    /// z = (p x² + 2 q x y + r y²)/2 has the shape operator ((p, q), (q, r)) at the origin,
    /// whatever the parameters' lines.
    #[test]
    fn a_paraboloid_under_skew_parameters() {
        let (p, q, r) = (2.0, 0.5, -1.0);
        let form = |a: &Vector, b: &Vector| p * a.x * b.x + q * (a.x * b.y + a.y * b.x) + r * a.y * b.y;
        let (u, v) = (Vector::new(3.0, 1.0, 0.0), Vector::new(2.0, 1.0, 0.0));
        let lifted = |a: &Vector, b: &Vector| Vector::new(0.0, 0.0, form(a, b));
        let jet =
            SurfaceJet { value: Vector::zeros(), u, v, uu: lifted(&u, &u), uv: lifted(&u, &v), vv: lifted(&v, &v) };
        let found = Differential::of(&jet).unwrap();
        assert!((found.gaussian - (p * r - q * q)).abs() < 1e-13 && (found.mean - 0.5 * (p + r)).abs() < 1e-14);
        for (k, d) in found.principal.into_iter().zip(&found.directions) {
            assert!((form(d, d) - k).abs() < 1e-13);
        }
    }
}
