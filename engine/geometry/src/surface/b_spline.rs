//! Tensor-product B-spline surfaces and their rational form, NURBS surfaces (Eqs. 6 and 9 over two
//! parameters).
//!
//! Control point (i, j) belongs to function i along u and j along v, and has the index `i · (number
//! along v) + j`.

use super::{Surface, SurfaceJet};
use crate::{
    BSplineBasis,
    space::{Dimension, HIGHEST_DEGREE, Vector, check_controls, degree_too_high, in_rows, no_weight},
};
use flankfit_numerics::check::Faults;

/// `S(u, v) = Σ wᵢⱼ aᵢⱼ Nᵢ(u) Nⱼ(v) / Σ wᵢⱼ Nᵢ(u) Nⱼ(v)`, or without weights the numerator with w =
/// 1.
#[derive(Clone, Debug, PartialEq)]
pub struct BSplineSurface {
    bases: [BSplineBasis; 2],
    dimension: Dimension,
    control_points: Vec<Vector>,
    weights: Option<Vec<f64>>,
}

impl BSplineSurface {
    /// Checks that points and weights match the bases; weights are ≥ 0, and somewhere above 0
    /// around every corner of spans.
    pub fn new(
        bases: [BSplineBasis; 2],
        dimension: Dimension,
        control_points: Vec<Vector>,
        weights: Option<Vec<f64>>,
    ) -> Result<Self, Faults> {
        if let Some(degree) = bases.iter().map(BSplineBasis::degree).find(|degree| *degree > HIGHEST_DEGREE) {
            return Err(degree_too_high("control_points", degree));
        }
        let [rows, columns] = bases.each_ref().map(BSplineBasis::size);
        check_controls(&control_points, weights.as_deref(), rows * columns, in_rows(columns))?;
        let surface = BSplineSurface { bases, dimension, control_points, weights };
        if surface.weights.is_some() {
            let [us, vs] = surface.breaks();
            for (u, v) in us.iter().flat_map(|u| vs.iter().map(move |v| (*u, *v))) {
                let weight = surface.sums(u, v, 0).1[0];
                if !(weight > 0.0 && weight.is_finite()) {
                    return Err(no_weight(u));
                }
            }
        }
        Ok(surface)
    }

    /// Knots and degrees along u and v.
    pub fn bases(&self) -> &[BSplineBasis; 2] {
        &self.bases
    }

    /// The control net, v running fastest.
    pub fn control_points(&self) -> &[Vector] {
        &self.control_points
    }

    /// One weight per control point, for a rational surface.
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// Weighted points and weights, summed with the bases' derivatives; in order: value, u, v, uu,
    /// uv, vv (up to `order`).
    fn sums(&self, u: f64, v: f64, order: usize) -> ([Vector; 6], [f64; 6]) {
        const ORDERS: [(usize, usize); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];
        let [along_u, along_v] = &self.bases;
        let mut nu = [[0.0; HIGHEST_DEGREE + 1]; 3];
        let mut nv = [[0.0; HIGHEST_DEGREE + 1]; 3];
        let (p, q) = (along_u.degree(), along_v.degree());
        let (mut i0, mut j0) = (0, 0);
        for d in 0..=order {
            i0 = along_u.derivatives_of(d, u, &mut nu[d][..=p]);
            j0 = along_v.derivatives_of(d, v, &mut nv[d][..=q]);
        }
        let (mut points, mut weights) = ([Vector::zeros(); 6], [0.0; 6]);
        let wanted = [1, 3, 6][order];
        for i in 0..=p {
            let row = (i0 + i) * along_v.size() + j0;
            for j in 0..=q {
                let weight = self.weights.as_ref().map_or(1.0, |w| w[row + j]);
                let point = self.control_points[row + j];
                for (k, (du, dv)) in ORDERS[..wanted].iter().enumerate() {
                    let share = nu[*du][i] * nv[*dv][j] * weight;
                    points[k] += point * share;
                    weights[k] += share;
                }
            }
        }
        (points, weights)
    }
}

/// The jet of P / w from those of P and of w, each in the order value, u, v, uu, uv, vv: Leibniz'
/// rule on S · w = P.
#[inline(always)]
pub(super) fn quotient(p: &[Vector; 6], w: &[f64; 6]) -> SurfaceJet {
    let value = p[0] / w[0];
    let u = (p[1] - value * w[1]) / w[0];
    let v = (p[2] - value * w[2]) / w[0];
    SurfaceJet {
        value,
        u,
        v,
        uu: (p[3] - u * (2.0 * w[1]) - value * w[3]) / w[0],
        uv: (p[4] - u * w[2] - v * w[1] - value * w[4]) / w[0],
        vv: (p[5] - v * (2.0 * w[2]) - value * w[5]) / w[0],
    }
}

impl Surface for BSplineSurface {
    fn dimension(&self) -> Dimension {
        self.dimension
    }

    fn domain(&self) -> [[f64; 2]; 2] {
        [self.bases[0].domain().into(), self.bases[1].domain().into()]
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        let (p, w) = self.sums(u, v, 2);
        if self.weights.is_none() {
            return SurfaceJet { value: p[0], u: p[1], v: p[2], uu: p[3], uv: p[4], vv: p[5] };
        }
        quotient(&p, &w)
    }

    fn value(&self, u: f64, v: f64) -> Vector {
        let (p, w) = self.sums(u, v, 0);
        if self.weights.is_none() { p[0] } else { p[0] / w[0] }
    }

    fn bends(&self, cuts: [&[f64]; 2]) -> Option<Vec<[f64; 3]>> {
        self.second_derivative_bounds(cuts)
    }

    fn breaks(&self) -> [Vec<f64>; 2] {
        [self.bases[0].distinct_knots(), self.bases[1].distinct_knots()]
    }
}
