//! Any surface of this crate, as one value that can be kept, written down and evaluated.

use super::{BSplineSurface, BezierSurface, CoonsPatch, GregoryPatch, Patchwork, Surface, SurfaceJet};
use crate::space::{Dimension, Vector};
use flankfit_numerics::cancel;

/// One of the representations that a surface can be built of.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceShape {
    /// B-spline, or NURBS where it has weights.
    BSpline(BSplineSurface),
    /// Tensor Bézier patch, rational where it has weights.
    Bezier(BezierSurface),
    /// Coons patch, bicubically blended where it has cross derivatives.
    Coons(Box<CoonsPatch>),
    /// Rational bicubic patch of 20 control points.
    Gregory(Box<GregoryPatch>),
    /// Several patches on a grid of parameters.
    Patchwork(Patchwork),
}

impl SurfaceShape {
    /// The surface behind the name.
    pub fn surface(&self) -> &dyn Surface {
        match self {
            SurfaceShape::BSpline(surface) => surface,
            SurfaceShape::Bezier(surface) => surface,
            SurfaceShape::Coons(surface) => surface.as_ref(),
            SurfaceShape::Gregory(surface) => surface.as_ref(),
            SurfaceShape::Patchwork(surface) => surface,
        }
    }
}

impl Surface for SurfaceShape {
    fn dimension(&self) -> Dimension {
        self.surface().dimension()
    }

    fn domain(&self) -> [[f64; 2]; 2] {
        self.surface().domain()
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        cancel::checkpoint();
        self.surface().jet(u, v)
    }

    fn value(&self, u: f64, v: f64) -> Vector {
        cancel::checkpoint();
        self.surface().value(u, v)
    }

    fn bends(&self, cuts: [&[f64]; 2]) -> Option<Vec<[f64; 3]>> {
        self.surface().bends(cuts)
    }

    fn breaks(&self) -> [Vec<f64>; 2] {
        self.surface().breaks()
    }
}
