//! Stability of a curve through points: the paper's warnings about oscillation, as figures.
//!
//! - The Lebesgue constant: by how much errors of the values can be amplified anywhere on the curve
//!   ([`super::lebesgue`]).
//! - The overshoot: how far the curve leaves the range of the two nodes it runs between
//!   ([`super::overshoot`]).
//! - The condition of the equations that were solved ([`super::condition`]).
//! - How exactly the curve passes through its points after all rounding.

use super::{
    Curve, CurveShape,
    condition::condition,
    figure::Absence,
    lebesgue::{Lebesgue, lebesgue},
    method::{Method, Nodes},
    overshoot::{Overshoot, overshoot},
};

/// Stability of a curve through points.
#[derive(Clone, Debug, PartialEq)]
pub struct Stability {
    /// The largest amplification of errors of the values.
    pub lebesgue: Result<Lebesgue, Absence>,
    /// The largest excursion outside the range of neighbouring nodes; None where the curve never
    /// leaves it.
    pub overshoot: Option<Overshoot>,
    /// The 2-norm condition number of the interpolation matrix.
    pub condition: Result<f64, Absence>,
    /// The largest distance in one coordinate between a point and the curve at its parameter.
    pub interpolation_error: f64,
}

pub(super) fn stability(nodes: &Nodes, method: &Method, shape: &CurveShape) -> Stability {
    let misses = nodes.parameters.iter().zip(&nodes.values).map(|(t, v)| (shape.value(*t) - v).amax());
    Stability {
        lebesgue: lebesgue(nodes, method, shape),
        overshoot: overshoot(shape, &nodes.parameters, &nodes.values),
        condition: condition(nodes, method),
        interpolation_error: misses.fold(0.0, f64::max),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::{Ends, KnotChoice, Parametrization, Points, Tangents, through};
    use crate::space::{Dimension, Vector};

    fn of(x: &[f64], method: Method) -> Stability {
        let y = x.iter().map(|x| 1.0 / (1.0 + 25.0 * x * x)).collect();
        through(&Points::Graph { x: x.to_vec(), y }, &method).unwrap().stability
    }

    fn equal(n: i32, low: f64, high: f64) -> Vec<f64> {
        (0..n).map(|i| low + (high - low) * f64::from(i) / f64::from(n - 1)).collect()
    }

    fn assert_near(got: f64, truth: f64, tolerance: f64) {
        assert!((got / truth - 1.0).abs() < tolerance, "{got:.17e} for {truth:e}");
    }

    /// Constants of equal steps as published (Brutman 1997): 1.25 for 3 nodes, 29.900 for 11.
    #[test]
    fn lebesgue_constants_of_polynomials() {
        assert_near(of(&equal(3, 5.0, 6.0), Method::Lagrange).lebesgue.unwrap().constant, 1.25, 1e-14);
        for method in [Method::Lagrange, Method::Newton] {
            let stability = of(&equal(11, -1.0, 1.0), method);
            assert_near(stability.lebesgue.unwrap().constant, 29.900, 1e-4);
            assert!(stability.overshoot.unwrap().amount > 1.8 && stability.interpolation_error < 1e-15);
        }
        // as a Hermite polynomial without derivatives
        let hermite = of(&equal(11, -1.0, 1.0), Method::Hermite { derivatives: vec![Vec::new(); 11] });
        let lagrange = of(&equal(11, -1.0, 1.0), Method::Lagrange);
        assert_near(hermite.lebesgue.unwrap().constant, lagrange.lebesgue.unwrap().constant, 1e-12);
        assert_near(hermite.condition.unwrap(), lagrange.condition.unwrap(), 1e-12);
    }

    /// Two cubics with slopes 0 at the nodes are a partition of unity of functions ≥ 0: the
    /// constant is 1. Catmull and Rom: the four functions at the middle of equal spans are −1, 9,
    /// 9, −1 sixteenths.
    #[test]
    fn lebesgue_constants_of_cubics() {
        let x = equal(6, 0.0, 5.0);
        let zero = Method::CubicHermite(Tangents::Given(vec![Vector::x(); 6]));
        assert_near(of(&x, zero).lebesgue.unwrap().constant, 1.0, 1e-14);
        let catmull_rom = of(&x, Method::CubicHermite(Tangents::CatmullRom));
        assert_near(catmull_rom.lebesgue.unwrap().constant, 1.25, 1e-14);
        assert_eq!(catmull_rom.condition, Err(Absence::NoEquations));
        assert_eq!(of(&x, Method::CubicHermite(Tangents::Akima)).lebesgue, Err(Absence::NotLinear));
        // one curve, two methods
        let spline = of(&x, Method::CubicSpline(Ends::not_a_knot())).lebesgue.unwrap().constant;
        let knots = KnotChoice::NotAKnot;
        let b_spline = of(&x, Method::BSpline { degree: 3, knots }).lebesgue.unwrap().constant;
        assert_near(spline, b_spline, 1e-10);
        let many = of(&equal(401, 0.0, 1.0), Method::CubicSpline(Ends::natural()));
        assert_eq!(many.lebesgue, Err(Absence::TooMany { nodes: 401, most: 400 }));
        // (1 + 3√3) / 4 is the constant of the cardinal spline on all integers (Richards 1973)
        let t = equal(40, 0.0, 1.0);
        let y = t.iter().map(|t| (t * std::f64::consts::TAU).cos()).collect();
        let periodic = through(&Points::Graph { x: t, y }, &Method::CubicSpline(Ends::Periodic)).unwrap();
        assert_near(periodic.stability.lebesgue.unwrap().constant, 0.25 * (1.0 + 27f64.sqrt()), 1e-9);
    }

    /// The matrix of (−1, 0, 1) has the singular values √2 and those of [[√3, 2/√3], [0, √(2/3)]]:
    /// from AᵀA.
    #[test]
    fn conditions() {
        let squares = [0.5 * (5.0 - 17f64.sqrt()), 0.5 * (5.0 + 17f64.sqrt())];
        let exact = (squares[1] / squares[0]).sqrt();
        assert_near(of(&[-1.0, 0.0, 1.0], Method::Lagrange).condition.unwrap(), exact, 1e-12);
        // far above what a double could show
        assert!(of(&equal(12, 30.0, 40.0), Method::Newton).condition.unwrap() > 1e25);
        // diagonally dominant equations are tame however many
        let spline = of(&equal(300, 0.0, 1.0), Method::CubicSpline(Ends::natural())).condition.unwrap();
        assert!((2.0..3.1).contains(&spline), "{spline}");
        let degree = |degree| Method::BSpline { degree, knots: KnotChoice::Averaging };
        assert_near(of(&equal(9, 0.0, 1.0), degree(1)).condition.unwrap(), 1.0, 1e-14);
        assert!(of(&equal(300, 0.0, 1.0), degree(5)).condition.unwrap() > 5.0);
    }

    #[test]
    fn of_points_in_space() {
        let points: Vec<Vector> =
            (0..20).map(|i| f64::from(i) * 0.3).map(|t| Vector::new(t.cos(), t.sin(), t)).collect();
        let parametrization = Parametrization::Centripetal;
        let points = Points::Space { points, dimension: Dimension::Space, parametrization };
        let curve = through(&points, &Method::BSpline { degree: 3, knots: KnotChoice::Averaging }).unwrap();
        assert!(curve.stability.interpolation_error < 1e-14 && curve.stability.lebesgue.unwrap().constant < 3.0);
        assert_eq!(curve.parameters.len(), 20);
        assert!(curve.stability.overshoot.unwrap().amount < 0.02);
    }
}
