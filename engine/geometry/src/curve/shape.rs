//! Any curve of this crate, as one value that can be kept, written down and evaluated.

use super::{BSplineCurve, Curve, CurveJet, PiecewisePolynomial, Polynomial};
use crate::space::{Dimension, Vector};
use flankfit_numerics::cancel;

/// One of the representations that a curve can be built of.
#[derive(Clone, Debug, PartialEq)]
pub enum CurveShape {
    /// B-spline, or NURBS where it has weights.
    BSpline(BSplineCurve),
    /// Cubic Hermite curve or cubic spline, or any other curve of polynomial pieces.
    PiecewisePolynomial(PiecewisePolynomial),
    /// One polynomial over the whole domain.
    Polynomial(Polynomial),
}

impl CurveShape {
    fn curve(&self) -> &dyn Curve {
        match self {
            CurveShape::BSpline(curve) => curve,
            CurveShape::PiecewisePolynomial(curve) => curve,
            CurveShape::Polynomial(curve) => curve,
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
        cancel::checkpoint();
        self.curve().jet(t)
    }

    fn breaks(&self) -> Vec<f64> {
        self.curve().breaks()
    }

    fn value(&self, t: f64) -> Vector {
        cancel::checkpoint();
        self.curve().value(t)
    }
}
