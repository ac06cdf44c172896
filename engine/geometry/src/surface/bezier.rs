//! Tensor Bézier patches, also rational: `S(u, v) = Σ wᵢⱼ aᵢⱼ Bᵢ(s) Bⱼ(t) / Σ wᵢⱼ Bᵢ(s) Bⱼ(t)` with
//! Bernstein polynomials of the parameters mapped to [0, 1].
//!
//! Bernstein polynomials are the B-splines of one span, so the patch is kept as such; only its
//! degrees are those of the net.

use super::{BSplineSurface, Surface, SurfaceJet};
use crate::{
    BSplineBasis, KnotFault,
    space::{ControlFault, Dimension, HIGHEST_DEGREE, Vector},
};
use flankfit_numerics::fault::words::Shown;

/// A patch over one rectangle, its net having (degree + 1) control points along each parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierSurface {
    spline: BSplineSurface,
}

/// Why a Bézier net is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BezierFault {
    /// A net with fewer than two control points along a parameter.
    #[error("{rows} × {columns} control points are no net: along each parameter there must be at least 2")]
    Net {
        /// Control points along u.
        rows: usize,
        /// Control points along v.
        columns: usize,
    },
    /// A domain without width.
    #[error("the domain [{}, {}] has no width", Shown(*.low), Shown(*.high))]
    Domain {
        /// The axis: 0 for u, 1 for v.
        axis: usize,
        /// Lower end of the domain.
        low: f64,
        /// Upper end of the domain.
        high: f64,
    },
    /// The control points or weights are refused.
    #[error(transparent)]
    Control(#[from] ControlFault),
}

impl BezierSurface {
    /// `shape` counts the control points along u and v (degree + 1 each, 2 to 26); `control_points`
    /// with v running fastest; `domain` the ranges of u and v, usually [0, 1] both; weights ≥ 0 for
    /// a rational patch.
    ///
    /// ```
    /// use flankfit_geometry::{
    ///     space::{Dimension, Vector},
    ///     surface::{BezierSurface, Surface},
    /// };
    ///
    /// // The saddle z = uv.
    /// let heights = [0.0, 0.0, 0.0, 1.0].map(|z| Vector::new(z, 0.0, 0.0)).to_vec();
    /// let unit = [[0.0, 1.0]; 2];
    /// let saddle = BezierSurface::new([2, 2], unit, Dimension::Graph, heights, None)?;
    /// assert_eq!(saddle.value(0.5, 0.25).x, 0.125);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(
        shape: [usize; 2],
        domain: [[f64; 2]; 2],
        dimension: Dimension,
        control_points: Vec<Vector>,
        weights: Option<Vec<f64>>,
    ) -> Result<Self, BezierFault> {
        let [rows, columns] = shape;
        if rows < 2 || columns < 2 {
            return Err(BezierFault::Net { rows, columns });
        }
        if let Some(degree) = shape.into_iter().map(|n| n - 1).find(|degree| *degree > HIGHEST_DEGREE) {
            return Err(ControlFault::Degree { degree }.into());
        }
        let basis = |axis: usize| one_span(shape[axis] - 1, domain[axis]).map_err(|_| no_width(axis, domain[axis]));
        let bases = [basis(0)?, basis(1)?];
        Ok(BezierSurface { spline: BSplineSurface::new(bases, dimension, control_points, weights)? })
    }

    /// Degrees along u and v.
    pub fn degrees(&self) -> [usize; 2] {
        self.spline.bases().each_ref().map(BSplineBasis::degree)
    }

    /// The net, v running fastest.
    pub fn control_points(&self) -> &[Vector] {
        self.spline.control_points()
    }

    /// One weight per control point, for a rational patch.
    pub fn weights(&self) -> Option<&[f64]> {
        self.spline.weights()
    }

    /// The same patch as a B-spline surface of one span.
    pub fn as_b_spline(&self) -> &BSplineSurface {
        &self.spline
    }
}

fn no_width(axis: usize, [low, high]: [f64; 2]) -> BezierFault {
    BezierFault::Domain { axis, low, high }
}

/// The Bernstein polynomials of `degree` on `[low, high]`.
pub(super) fn one_span(degree: usize, [low, high]: [f64; 2]) -> Result<BSplineBasis, KnotFault> {
    BSplineBasis::uniform(degree, 1, low, high)
}

impl Surface for BezierSurface {
    fn dimension(&self) -> Dimension {
        self.spline.dimension()
    }

    fn domain(&self) -> [[f64; 2]; 2] {
        self.spline.domain()
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        self.spline.jet(u, v)
    }

    fn value(&self, u: f64, v: f64) -> Vector {
        self.spline.value(u, v)
    }

    fn bends(&self, cuts: [&[f64]; 2]) -> Option<Vec<[f64; 3]>> {
        self.spline.bends(cuts)
    }

    fn breaks(&self) -> [Vec<f64>; 2] {
        self.spline.breaks()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: [[f64; 2]; 2] = [[0.0, 1.0]; 2];

    #[test]
    fn degrees_are_those_of_the_net() {
        let net = (0..6).map(|k| Vector::new(f64::from(k), 0.0, 0.0)).collect();
        let patch = BezierSurface::new([2, 3], UNIT, Dimension::Graph, net, None).unwrap();
        assert_eq!(patch.degrees(), [1, 2]);
        // control points that are linear in their places make a plane
        assert!((patch.value(0.25, 0.5).x - 1.75).abs() < 1e-15);
    }

    #[test]
    fn refused_nets() {
        let net = |n: usize| vec![Vector::zeros(); n];
        let new =
            |shape, domain, points| BezierSurface::new(shape, domain, Dimension::Space, points, None).unwrap_err();
        assert_eq!(new([1, 3], UNIT, net(3)), BezierFault::Net { rows: 1, columns: 3 });
        assert_eq!(new([2, 2], [[0.0, 1.0], [2.0, 2.0]], net(4)), BezierFault::Domain { axis: 1, low: 2.0, high: 2.0 });
        assert_eq!(new([2, 2], UNIT, net(3)), ControlFault::Count { given: 3, wanted: 4 }.into());
        assert_eq!(new([40, 2], UNIT, net(80)), ControlFault::Degree { degree: 39 }.into());
    }
}
