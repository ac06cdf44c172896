//! Rational bicubic Gregory patches of 20 control points (Gregory 1974; Chiyokura and Kimura 1983).
//!
//! A bicubic Bézier patch whose four inner control points are pairs, `a` and `b`, mixed by the
//! parameters s, t of the unit square: `P₁₁ = (s a + t b)/(s + t)` and its mirror images at the
//! other corners. So on s = 0 and s = 1 only the b points act on the derivative across the border,
//! on t = 0 and t = 1 only the a points: each border takes its own cross derivative, whether or not
//! they agree about the twist at the corner. Where they do not, the second derivatives have no
//! limit at the corner; returned there are S_uu and S_vv along the borders and the mean of the
//! two twists.

use super::{
    Surface, SurfaceJet,
    bezier::one_span,
    check,
    corner::twist_share_at,
    jets::{Blend, product},
};
use crate::space::{Dimension, Vector, control_not_finite, in_rows};
use flankfit_numerics::check::Faults;

/// The control points: a 4 × 4 net (i along u, j along v) whose inner four are the `a` points, and
/// the `b` points of these four.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GregoryNet {
    /// The net `[i][j]`, i along u and j along v, with the a points inside.
    pub net: [[Vector; 4]; 4],
    /// `b[i][j]` belongs to `net[i + 1][j + 1]`.
    pub b: [[Vector; 2]; 2],
}

/// A patch over one rectangle.
#[derive(Clone, Debug, PartialEq)]
pub struct GregoryPatch {
    domain: [[f64; 2]; 2],
    dimension: Dimension,
    points: GregoryNet,
    /// The net with the middle of each pair.
    middle: [[Vector; 4]; 4],
}

impl GregoryPatch {
    /// Checks that every number is finite and that the domain has a width.
    pub fn new(domain: [[f64; 2]; 2], dimension: Dimension, points: GregoryNet) -> Result<Self, Faults> {
        for (axis, [low, high]) in domain.into_iter().enumerate() {
            if one_span(1, [low, high]).is_err() {
                return Err(check::no_width(axis, [low, high]));
            }
        }
        let mut all = points.net.iter().flatten().chain(points.b.iter().flatten());
        if let Some(index) = all.position(|p| !p.iter().all(|x| x.is_finite())) {
            let path = match index.checked_sub(16) {
                Some(inner) => format!("inner_points{}", in_rows(2)(inner)),
                None => format!("control_points{}", in_rows(4)(index)),
            };
            return Err(control_not_finite(index, &path));
        }
        let mut middle = points.net;
        for (i, j) in CORNERS {
            middle[i + 1][j + 1] = (points.net[i + 1][j + 1] + points.b[i][j]) * 0.5;
        }
        Ok(GregoryPatch { domain, dimension, points, middle })
    }

    /// The 20 control points.
    pub fn points(&self) -> &GregoryNet {
        &self.points
    }

    /// Whether each pair is one point, so that the patch is a bicubic Bézier patch.
    pub fn is_polynomial(&self) -> bool {
        CORNERS.iter().all(|&(i, j)| self.points.net[i + 1][j + 1] == self.points.b[i][j])
    }

    fn local(&self, u: f64, v: f64) -> (f64, f64) {
        let [[a, b], [c, d]] = self.domain;
        ((u - a) / (b - a), (v - c) / (d - c))
    }
}

const CORNERS: [(usize, usize); 4] = [(0, 0), (0, 1), (1, 0), (1, 1)];

/// The cubic Bernstein polynomials with two derivatives.
fn bernstein(s: f64) -> [Blend; 4] {
    let r = 1.0 - s;
    [
        [r * r * r, -3.0 * r * r, 6.0 * r],
        [3.0 * s * r * r, 3.0 * r * (r - 2.0 * s), 6.0 * (s - 2.0 * r)],
        [3.0 * s * s * r, 3.0 * s * (2.0 * r - s), 6.0 * (r - 2.0 * s)],
        [s * s * s, 3.0 * s * s, 6.0 * s],
    ]
}

impl Surface for GregoryPatch {
    fn dimension(&self) -> Dimension {
        self.dimension
    }

    fn domain(&self) -> [[f64; 2]; 2] {
        self.domain
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        let (s, t) = self.local(u, v);
        let (along_u, along_v) = (bernstein(s), bernstein(t));
        let mut jet = SurfaceJet::zero();
        for (row, bu) in self.middle.iter().zip(along_u) {
            for (point, bv) in row.iter().zip(along_v) {
                jet.add(point, &product(bu, bv));
            }
        }
        for (i, j) in CORNERS {
            // 9 from the two middle Bernstein polynomials, 1/2 from the pair's half difference
            let half = (self.points.net[i + 1][j + 1] - self.points.b[i][j]) * 4.5;
            jet.add(&half, &twist_share_at([i, j], s, t));
        }
        let [[a, b], [c, d]] = self.domain;
        jet.scaled([1.0 / (b - a), 1.0 / (d - c)])
    }

    fn value(&self, u: f64, v: f64) -> Vector {
        let (s, t) = self.local(u, v);
        let (along_u, along_v) = (bernstein(s), bernstein(t));
        let mut value = Vector::zeros();
        for (row, bu) in self.middle.iter().zip(along_u) {
            for (point, bv) in row.iter().zip(along_v) {
                value += point * (bu[0] * bv[0]);
            }
        }
        for (i, j) in CORNERS {
            let half = (self.points.net[i + 1][j + 1] - self.points.b[i][j]) * 4.5;
            value += half * twist_share_at([i, j], s, t)[0];
        }
        value
    }

    fn bends(&self, cuts: [&[f64]; 2]) -> Option<Vec<[f64; 3]>> {
        self.to_b_spline()?.bends(cuts)
    }

    fn breaks(&self) -> [Vec<f64>; 2] {
        self.domain.map(Vec::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn net() -> GregoryNet {
        let place = |i: usize, j: usize| Vector::new(i as f64, j as f64, (i * i) as f64 - (2 * i * j) as f64);
        let net = std::array::from_fn(|i| std::array::from_fn(|j| place(i, j)));
        let b = std::array::from_fn(|i| std::array::from_fn(|j| place(i + 1, j + 1) + Vector::new(0.1, 0.2, 0.3)));
        GregoryNet { net, b }
    }

    /// The formula as printed in the books, away from corners.
    #[test]
    fn it_is_the_bezier_patch_of_its_mixed_points() {
        let patch = GregoryPatch::new([[0.0, 1.0]; 2], Dimension::Space, net()).unwrap();
        let points = net();
        for (s, t) in [(0.2, 0.7), (0.5, 0.5), (1e-9, 1e-12), (0.999, 0.001)] {
            let weight = |end: usize, x: f64| if end == 0 { x } else { 1.0 - x };
            let mut mixed = points.net;
            for (i, j) in CORNERS {
                let (p, q) = (weight(i, s), weight(j, t));
                mixed[i + 1][j + 1] = (points.net[i + 1][j + 1] * p + points.b[i][j] * q) / (p + q);
            }
            let (bu, bv) = (bernstein(s), bernstein(t));
            let mut sum = Vector::zeros();
            for i in 0..4 {
                for j in 0..4 {
                    sum += mixed[i][j] * (bu[i][0] * bv[j][0]);
                }
            }
            assert!((patch.value(s, t) - sum).norm() < 1e-14);
            assert_eq!(patch.value(s, t), patch.jet(s, t).value);
        }
    }

    #[test]
    fn refused_nets() {
        let bad = |domain, points| GregoryPatch::new(domain, Dimension::Space, points).unwrap_err();
        let domain = [[0.0, 1.0], [1.0, 0.0]];
        assert_eq!(bad(domain, net()).to_string(), "domain[1]: the domain [1, 0] has no width");
        let mut points = net();
        points.b[1][0].y = f64::INFINITY;
        let message = bad([[0.0, 1.0]; 2], points).to_string();
        assert_eq!(message, "inner_points[1][0]: control point 18 is not finite");
    }
}
