//! Curves: y(x) over an axis, or points of plane or space over a parameter (sections 2.1 and 2.2 of
//! the paper).
//!
//! A curve is anything that can tell its domain and its jet: value and derivatives to order 3 at a
//! parameter. What follows from these alone (curvature, arc length, the closest point) is written
//! once, for every curve.
//!
//! Parameters outside the domain are the caller's mistake and are refused beforehand; here the end
//! piece goes on.

pub mod b_spline;
pub mod barycentric;
mod bernstein;
mod check;
pub mod closest;
pub mod condition;
pub mod construct;
pub mod cubic_hermite;
pub mod cubic_spline;
mod ends;
mod figure;
pub mod interpolate;
pub mod knots;
pub mod lebesgue;
pub mod measure;
mod method;
pub mod newton;
pub mod overshoot;
pub mod parametrization;
pub mod piecewise;
pub mod polynomial;
pub mod refine;
pub mod shape;
mod spline_system;
pub mod stability;
mod tangents;
pub mod to_b_spline;

pub use b_spline::BSplineCurve;
pub use closest::{Closest, ClosestPoint};
pub use construct::{Constructed, through};
pub use cubic_hermite::cubic_hermite;
pub use cubic_spline::cubic_spline;
pub use ends::{End, Ends};
pub use figure::Absence;
pub use interpolate::{Collocation, KnotChoice, interpolate};
pub use measure::{ArcLength, Bending, arc_length, arc_lengths, bending};
pub use method::{Method, Points};
pub use parametrization::Parametrization;
pub use piecewise::PiecewisePolynomial;
pub use polynomial::Polynomial;
pub use shape::CurveShape;
pub use stability::Stability;
pub use tangents::Tangents;

use super::space::{Dimension, Vector};

/// Value, first, second and third derivative by the parameter.
pub type CurveJet = [Vector; 4];

/// A curve over one parameter.
pub trait Curve {
    /// How many coordinates its values have.
    fn dimension(&self) -> Dimension;

    /// The range of the parameter, low < high.
    fn domain(&self) -> [f64; 2];

    /// Value and derivatives to order 3 at `t`. At a break the piece to the right counts, at the
    /// end of the domain the last one.
    fn jet(&self, t: f64) -> CurveJet;

    /// The places, both ends included and ascending, between which the curve is infinitely smooth.
    fn breaks(&self) -> Vec<f64>;

    /// The point or number at `t`.
    fn value(&self, t: f64) -> Vector {
        self.jet(t)[0]
    }

    /// The jet of the curve's place in plane or space: (x, y(x)) for a graph, else the jet itself.
    fn place(&self, t: f64) -> CurveJet {
        let jet = self.jet(t);
        if self.dimension().is_parametric() {
            return jet;
        }
        let raised = |x: f64, y: &Vector| Vector::new(x, y.x, 0.0);
        [raised(t, &jet[0]), raised(1.0, &jet[1]), raised(0.0, &jet[2]), raised(0.0, &jet[3])]
    }
}
