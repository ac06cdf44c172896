//! Tensor Bézier patches, also rational: `S(u, v) = Σ wᵢⱼ aᵢⱼ Bᵢ(s) Bⱼ(t) / Σ wᵢⱼ Bᵢ(s) Bⱼ(t)` with
//! Bernstein polynomials of the parameters mapped to [0, 1].
//!
//! Bernstein polynomials are the B-splines of one span, so the patch is kept as such; only its
//! degrees are those of the net.

use super::{BSplineSurface, Surface, SurfaceJet, check};
use crate::{
    BSplineBasis,
    space::{Dimension, HIGHEST_DEGREE, Vector, degree_too_high},
};
use flankfit_numerics::check::Faults;

/// A patch over one rectangle, its net having (degree + 1) control points along each parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierSurface {
    spline: BSplineSurface,
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
    ) -> Result<Self, Faults> {
        let [rows, columns] = shape;
        if rows < 2 || columns < 2 {
            let message = format_args!("{rows} × {columns} control points: at least 2 are needed along each parameter");
            return Err(Faults::one("control_points", message));
        }
        if let Some(degree) = shape.into_iter().map(|n| n - 1).find(|degree| *degree > HIGHEST_DEGREE) {
            return Err(degree_too_high("control_points", degree));
        }
        let basis =
            |axis: usize| one_span(shape[axis] - 1, domain[axis]).map_err(|_| check::no_width(axis, domain[axis]));
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

/// The Bernstein polynomials of `degree` on `[low, high]`.
pub(super) fn one_span(degree: usize, [low, high]: [f64; 2]) -> Result<BSplineBasis, Faults> {
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
        let message = |shape, domain, points| new(shape, domain, points).to_string();
        assert!(message([1, 3], UNIT, net(3)).starts_with("control_points: 1 × 3 control points: at least 2"));
        let narrow = [[0.0, 1.0], [2.0, 2.0]];
        assert_eq!(message([2, 2], narrow, net(4)), "domain[1]: the domain [2, 2] has no width");
        assert_eq!(message([2, 2], UNIT, net(3)), "control_points: 3 control points; knots and degree need 4");
        assert!(message([40, 2], UNIT, net(80)).starts_with("control_points: degree 39 is above 25"));
    }
}
