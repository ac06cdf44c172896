//! Coons patches: a rectangle of parameters filled from its four boundary curves (Coons 1967;
//! Farin, ch. 22).
//!
//! The patch is the Boolean sum `P₁ + P₂ − P₁P₂` of two interpolations, P₁ across u and P₂ across
//! v. Bilinearly blended, each is linear between opposite curves. Bicubically blended, each is
//! cubic and takes the derivative across each border too, so that patches that share a border's
//! curve and cross derivative meet smoothly.
//!
//! The derivatives across the borders are given, or cubics between the tangents of the neighbouring
//! borders, whose end slopes are the twists (mixed derivatives at the corners). Where the
//! derivatives given along two borders imply different twists at their corner, the twist is
//! Gregory's rational mixture (`corner.rs`), which keeps both.

use super::{
    Surface, SurfaceJet,
    bezier::one_span,
    boundaries::{Border, Boundaries, CORNERS, breaks_over, jet_over, merged},
    check,
    corner::twist_share_at,
    jets::Blend,
};
use crate::{
    curve::{BSplineCurve, Curve, CurveShape},
    space::{Dimension, Vector},
};
use flankfit_numerics::check::Faults;

/// How the twists at the corners are found for cross derivatives that are not given.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Twists {
    /// Those of the bilinearly blended patch of the same borders (Adini): right for every surface
    /// u·f(v) + g(v) + v·h(u) + k(u).
    #[default]
    Adini,
    /// None (Ferguson): flat spots at the corners.
    Zero,
    /// S_uv at the corner of borders uᵢ and vⱼ as `[i][j]`.
    Given([[Vector; 2]; 2]),
}

/// A patch that reproduces its four boundary curves, and when bicubically blended the derivatives
/// across them.
#[derive(Clone, Debug, PartialEq)]
pub struct CoonsPatch {
    boundaries: Boundaries,
    cross: Option<Cross>,
}

#[derive(Clone, Debug, PartialEq)]
struct Cross {
    /// ∂S/∂u along u0 and u1, ∂S/∂v along v0 and v1.
    curves: [CurveShape; 4],
    /// Tangents (∂S/∂u, ∂S/∂v) at the corners.
    tangents: [[[Vector; 2]; 2]; 2],
    /// The twist at corner [i][j] by border uᵢ and by border vⱼ.
    twists: [[[Vector; 2]; 2]; 2],
}

impl CoonsPatch {
    /// The bilinearly blended patch.
    pub fn bilinear(boundaries: Boundaries) -> Self {
        CoonsPatch { boundaries, cross: None }
    }

    /// The bicubically blended patch. `cross` in the order u0, u1, v0, v1: the derivative of the
    /// patch across each border, by u or v, over the border's domain; what is missing is estimated.
    /// A cross derivative given must agree at its ends with the tangents of the borders that run
    /// there: their difference times the width of the patch is at most `tolerance`.
    pub fn bicubic(
        boundaries: Boundaries,
        cross: [Option<CurveShape>; 4],
        twists: &Twists,
        tolerance: f64,
    ) -> Result<Self, Faults> {
        let cross = Cross::new(&boundaries, cross, twists, tolerance)?;
        Ok(CoonsPatch { boundaries, cross: Some(cross) })
    }

    /// The curves it reproduces.
    pub fn boundaries(&self) -> &Boundaries {
        &self.boundaries
    }

    /// The derivatives across the borders u0, u1, v0, v1, of a bicubically blended patch.
    pub fn cross_derivatives(&self) -> Option<&[CurveShape; 4]> {
        self.cross.as_ref().map(|cross| &cross.curves)
    }

    /// Whether every corner has one twist, so that second derivatives are continuous there.
    pub fn has_one_twist_at_each_corner(&self) -> bool {
        self.cross.as_ref().is_none_or(|cross| cross.twists.iter().flatten().all(|[by_u, by_v]| by_u == by_v))
    }

    /// ∂S/∂u, ∂S/∂v and the mean of the twists at corner (i, j), of a bicubically blended patch.
    pub fn corner_derivatives(&self, i: usize, j: usize) -> Option<[Vector; 3]> {
        let cross = self.cross.as_ref()?;
        let ([along_u, along_v], [by_u, by_v]) = (cross.tangents[i][j], cross.twists[i][j]);
        Some([along_u, along_v, (by_u + by_v) * 0.5])
    }

    /// Blending functions of the values at the ends and of the derivatives there.
    fn blends(&self, axis: usize, x: f64) -> [[Blend; 2]; 2] {
        let [low, high] = self.boundaries.domain()[axis];
        let width = high - low;
        // each from its own end, so that it is 0 or 1 there exactly
        let (s, r) = ((x - low) / width, (high - x) / width);
        if self.cross.is_none() {
            return [[[r, -1.0 / width, 0.0], [s, 1.0 / width, 0.0]], [[0.0; 3]; 2]];
        }
        let curved = width * width;
        [
            [
                [r * r * (1.0 + 2.0 * s), -6.0 * s * r / width, (12.0 * s - 6.0) / curved],
                [s * s * (1.0 + 2.0 * r), 6.0 * s * r / width, (6.0 - 12.0 * s) / curved],
            ],
            [
                [width * s * r * r, r * (1.0 - 3.0 * s), (6.0 * s - 4.0) / width],
                [-width * s * s * r, s * (3.0 * s - 2.0), (6.0 * s - 2.0) / width],
            ],
        ]
    }
}

impl Surface for CoonsPatch {
    fn dimension(&self) -> Dimension {
        self.boundaries.dimension()
    }

    fn domain(&self) -> [[f64; 2]; 2] {
        self.boundaries.domain()
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        let ([value_u, slope_u], [value_v, slope_v]) = (self.blends(0, u), self.blends(1, v));
        let mut jet = SurfaceJet::zero();
        for end in 0..2 {
            jet.add_over_u(value_v[end], &self.boundaries.jet(2 + end, u));
            if let Some(cross) = &self.cross {
                jet.add_over_u(slope_v[end], &jet_over(&cross.curves[2 + end], self.domain()[0], u));
            }
        }
        // P₁ − P₁P₂: what the curves over v add to the blends of their own ends, which is 0 at
        // these
        for i in 0..2 {
            let mut rest = self.boundaries.jet(i, v);
            for j in 0..2 {
                take(&mut rest, value_v[j], &self.boundaries.corner(i, j));
                if let Some(cross) = &self.cross {
                    take(&mut rest, slope_v[j], &cross.tangents[i][j][1]);
                }
            }
            jet.add_over_v(value_u[i], &rest);
            if let Some(cross) = &self.cross {
                let mut rest = jet_over(&cross.curves[i], self.domain()[1], v);
                for j in 0..2 {
                    take(&mut rest, value_v[j], &cross.tangents[i][j][0]);
                    let [by_u, by_v] = cross.twists[i][j];
                    take(&mut rest, slope_v[j], &((by_u + by_v) * 0.5));
                }
                jet.add_over_v(slope_u[i], &rest);
            }
        }
        if let Some(cross) = &self.cross {
            self.take_rational_twists(cross, &mut jet, u, v);
        }
        jet
    }

    fn bends(&self, cuts: [&[f64]; 2]) -> Option<Vec<[f64; 3]>> {
        self.to_b_spline()?.bends(cuts)
    }

    fn breaks(&self) -> [Vec<f64>; 2] {
        let [us, vs] = self.boundaries.breaks();
        let Some(cross) = &self.cross else { return [us, vs] };
        let domain = self.domain();
        let along = |k: usize| breaks_over(&cross.curves[k], domain[Border::ALL[k].axis()]);
        [merged([us, along(2), along(3)]), merged([vs, along(0), along(1)])]
    }
}

impl CoonsPatch {
    /// The part of P₁P₂ in which the two twists of a corner differ.
    fn take_rational_twists(&self, cross: &Cross, jet: &mut SurfaceJet, u: f64, v: f64) {
        let [[a, b], [c, d]] = self.domain();
        let (wide, high) = (b - a, d - c);
        for (i, j) in CORNERS {
            let [by_u, by_v] = cross.twists[i][j];
            if by_u == by_v {
                continue;
            }
            // the slope blends of the two ends have opposite signs
            let sign = if i == j { 1.0 } else { -1.0 };
            let [w, ws, wt, wss, wst, wtt] = twist_share_at([i, j], (u - a) / wide, (v - c) / high);
            let share = [w, ws / wide, wt / high, wss / (wide * wide), wst / (wide * high), wtt / (high * high)];
            jet.add(&((by_u - by_v) * (-0.5 * sign * wide * high)), &share);
        }
    }
}

/// Subtracts `blend · point`.
fn take(rest: &mut [Vector; 3], blend: Blend, point: &Vector) {
    for (rest, blend) in rest.iter_mut().zip(blend) {
        *rest -= point * blend;
    }
}

impl Cross {
    fn new(
        boundaries: &Boundaries,
        given: [Option<CurveShape>; 4],
        twists: &Twists,
        tolerance: f64,
    ) -> Result<Self, Faults> {
        check::tolerance(tolerance)?;
        let domain = boundaries.domain();
        let tangents: [[[Vector; 2]; 2]; 2] =
            std::array::from_fn(|i| std::array::from_fn(|j| [boundaries.tangent(2 + j, i), boundaries.tangent(i, j)]));
        let mut corner_twists = corner_twists(boundaries, twists)?.map(|row| row.map(|twist| [twist; 2]));
        for border in Border::ALL {
            let Some(curve) = &given[border as usize] else { continue };
            if curve.dimension() != boundaries.dimension() {
                return Err(check::border_dimension(border, curve.dimension()));
            }
            let (along, across) = (border.axis(), border.axis() ^ 1);
            for end in 0..2 {
                let [value, slope, _] = jet_over(curve, domain[along], domain[along][end]);
                let [i, j] = if along == 1 { [border.end(), end] } else { [end, border.end()] };
                let gap = (value - tangents[i][j][across]).norm() * (domain[across][1] - domain[across][0]);
                if !(gap <= tolerance) {
                    return Err(check::cross_off(border, [i, j], gap, tolerance));
                }
                corner_twists[i][j][across] = slope;
                // a neighbour that is estimated takes the twist over
                let neighbour = if along == 1 { 2 + end } else { end };
                if given[neighbour].is_none() {
                    corner_twists[i][j][along] = slope;
                }
            }
        }
        let mut curves = Vec::with_capacity(4);
        for (border, given) in Border::ALL.into_iter().zip(given) {
            let (along, across) = (border.axis(), border.axis() ^ 1);
            let end = |e: usize| {
                let [i, j] = if along == 1 { [border.end(), e] } else { [e, border.end()] };
                (tangents[i][j][across], corner_twists[i][j][across])
            };
            let curve = match given {
                Some(curve) => curve,
                None => cubic(domain[along], boundaries.dimension(), [end(0), end(1)])
                    .ok_or_else(|| check::twist_not_finite([0, 0]))?,
            };
            curves.push(curve);
        }
        match <[CurveShape; 4]>::try_from(curves) {
            Ok(curves) => Ok(Cross { curves, tangents, twists: corner_twists }),
            Err(_) => Err(check::border_missing(Border::V1)),
        }
    }
}

/// The twists by the rule asked for.
pub(super) fn corner_twists(boundaries: &Boundaries, twists: &Twists) -> Result<[[Vector; 2]; 2], Faults> {
    match twists {
        Twists::Zero => Ok(Default::default()),
        Twists::Given(given) => match CORNERS.into_iter().find(|&(i, j)| !given[i][j].iter().all(|x| x.is_finite())) {
            Some((i, j)) => Err(check::twist_not_finite([i, j])),
            None => Ok(*given),
        },
        Twists::Adini => {
            let [[a, b], [c, d]] = boundaries.domain();
            let (wide, high) = (b - a, d - c);
            let corner = |i, j| boundaries.corner(i, j);
            let flat = (corner(1, 1) - corner(1, 0) - (corner(0, 1) - corner(0, 0))) / (wide * high);
            Ok(std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    let along_v = boundaries.tangent(1, j) - boundaries.tangent(0, j);
                    let along_u = boundaries.tangent(3, i) - boundaries.tangent(2, i);
                    along_v / wide + along_u / high - flat
                })
            }))
        }
    }
}

/// The cubic over `domain` with these values and slopes at its ends.
pub(super) fn cubic(domain: [f64; 2], dimension: Dimension, ends: [(Vector, Vector); 2]) -> Option<CurveShape> {
    let third = (domain[1] - domain[0]) / 3.0;
    let [(p0, d0), (p1, d1)] = ends;
    let points = vec![p0, p0 + d0 * third, p1 - d1 * third, p1];
    let basis = one_span(3, domain).ok()?;
    BSplineCurve::new(basis, dimension, points, None).ok().map(CurveShape::BSpline)
}
