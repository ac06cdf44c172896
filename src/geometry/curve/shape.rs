//! Any curve of the service, as one value that can be kept, written down and evaluated.

use super::{BSplineCurve, Curve, CurveJet};
use crate::geometry::space::Dimension;

/// One of the representations that a curve can be built of.
#[derive(Clone, Debug, PartialEq)]
pub enum CurveShape {
    /// B-spline, or NURBS where it has weights.
    BSpline(BSplineCurve),
}

impl CurveShape {
    fn curve(&self) -> &dyn Curve {
        match self {
            CurveShape::BSpline(curve) => curve,
        }
    }
}

impl Curve for CurveShape {
    fn dimension(&self) -> Dimension {
        self.curve().dimension()
    }

    fn domain(&self) -> [f64; 2] {
        self.curve().domain()
    }

    fn jet(&self, t: f64) -> CurveJet {
        self.curve().jet(t)
    }

    fn breaks(&self) -> Vec<f64> {
        self.curve().breaks()
    }
}
