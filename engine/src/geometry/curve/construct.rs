//! The one door to all curves through points: points, a method, and the curve with what is to be
//! said of its stability.

use super::{
    Curve, CurveFault, CurveShape, Ends, KnotChoice, Parametrization, Part, Polynomial, Tangents, cubic_hermite,
    cubic_spline, interpolate,
    stability::{Stability, stability},
};
use crate::geometry::space::{Dimension, Vector};

/// What the curve has to pass through.
#[derive(Clone, Debug, PartialEq)]
pub enum Points {
    /// (x, y(x)): as many y as x. Polynomials take the x in any order, everything else ascending;
    /// no order is ever changed.
    Graph { x: Vec<f64>, y: Vec<f64> },
    /// Points of plane or space, in the order in which the curve passes them.
    Space { points: Vec<Vector>, dimension: Dimension, parametrization: Parametrization },
}

/// How the curve is made. Derivatives are by x for a graph, by the parameter (0 to 1) for points of
/// plane or space.
#[derive(Clone, Debug, PartialEq)]
pub enum Method {
    /// One polynomial in the barycentric form (Eqs. 1 and 2).
    Lagrange,
    /// The same polynomial by divided differences.
    Newton,
    /// One polynomial that has also given derivatives: at node i those of order 1, 2, … in
    /// `derivatives[i]` (Eqs. 3 and 4).
    Hermite { derivatives: Vec<Vec<Vector>> },
    /// Cubics between the nodes with common tangents (Eq. 5).
    CubicHermite(Tangents),
    /// Cubics with continuous second derivative.
    CubicSpline(Ends),
    /// A B-spline of a degree from 1 (Eqs. 6 to 8).
    BSpline { degree: usize, knots: KnotChoice },
}

/// A curve through points.
#[derive(Clone, Debug, PartialEq)]
pub struct Constructed {
    pub shape: CurveShape,
    /// Where on the curve the points lie: x of a graph, else one parameter per point.
    pub parameters: Vec<f64>,
    /// How far the curve can be trusted between the points.
    pub stability: Stability,
}

/// Points as the methods take them: parameters and values.
pub(super) struct Nodes {
    pub dimension: Dimension,
    pub parameters: Vec<f64>,
    pub values: Vec<Vector>,
}

/// The curve through the points, with its stability.
///
/// ```
/// use flankfit_engine::geometry::curve::{Curve, Method, Points, through};
///
/// // Three equidistant nodes: the parabola x² + 1, whose Lebesgue constant is 5/4.
/// let points = Points::Graph { x: vec![0.0, 1.0, 2.0], y: vec![1.0, 2.0, 5.0] };
/// let made = through(&points, &Method::Lagrange)?;
/// assert!((made.shape.value(1.5).x - 3.25).abs() < 1e-14);
/// assert!((made.stability.lebesgue.unwrap().constant - 1.25).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn through(points: &Points, method: &Method) -> Result<Constructed, CurveFault> {
    let nodes = nodes(points)?;
    let shape = shape(&nodes, method)?;
    verify(&nodes, &shape)?;
    let stability = stability(&nodes, method, &shape);
    Ok(Constructed { shape, parameters: nodes.parameters, stability })
}

/// How far, in parts of the largest value, a curve may miss its nodes.
const MISS: f64 = 1e-3;

/// Refuses a curve through points that rounding has led past them.
fn verify(nodes: &Nodes, shape: &CurveShape) -> Result<(), CurveFault> {
    let largest = nodes.values.iter().fold(0.0f64, |most, value| most.max(value.amax()));
    for (index, (t, value)) in nodes.parameters.iter().zip(&nodes.values).enumerate() {
        let miss = (shape.value(*t) - value).amax();
        if !(miss <= MISS * largest) {
            return Err(CurveFault::Misses { index, miss });
        }
    }
    Ok(())
}

/// The curve alone, with the parameters of the points.
///
/// ```
/// use flankfit_engine::geometry::curve::{Curve, Ends, Method, Points, construct::shape_through};
///
/// // A natural spline over 0, 1, 0: its second derivative in the middle is −3, and between the
/// // first two nodes it is y = 3x/2 − x³/2.
/// let points = Points::Graph { x: vec![0.0, 1.0, 2.0], y: vec![0.0, 1.0, 0.0] };
/// let (spline, parameters) = shape_through(&points, &Method::CubicSpline(Ends::natural()))?;
/// assert_eq!(parameters, [0.0, 1.0, 2.0]);
/// assert!((spline.value(0.5).x - 0.6875).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn shape_through(points: &Points, method: &Method) -> Result<(CurveShape, Vec<f64>), CurveFault> {
    let nodes = nodes(points)?;
    let shape = shape(&nodes, method)?;
    verify(&nodes, &shape)?;
    Ok((shape, nodes.parameters))
}

fn nodes(points: &Points) -> Result<Nodes, CurveFault> {
    match points {
        Points::Graph { x, y } => {
            if x.len() != y.len() {
                return Err(CurveFault::Count { part: Part::Y, given: y.len(), wanted: x.len() });
            }
            let values = y.iter().map(|y| Vector::new(*y, 0.0, 0.0)).collect();
            Ok(Nodes { dimension: Dimension::Graph, parameters: x.clone(), values })
        }
        Points::Space { points, dimension, parametrization } => {
            let parameters = parametrization.parameters(points)?;
            Ok(Nodes { dimension: *dimension, parameters, values: points.clone() })
        }
    }
}

pub(super) fn shape(nodes: &Nodes, method: &Method) -> Result<CurveShape, CurveFault> {
    let Nodes { dimension, parameters, values } = nodes;
    let dimension = *dimension;
    Ok(match method {
        Method::Lagrange => {
            CurveShape::Polynomial(Polynomial::lagrange(dimension, parameters.clone(), values.clone())?)
        }
        Method::Newton => CurveShape::Polynomial(Polynomial::newton(dimension, parameters, values)?),
        Method::Hermite { derivatives } => {
            if derivatives.len() != values.len() {
                let (given, wanted) = (derivatives.len(), values.len());
                return Err(CurveFault::Count { part: Part::Derivatives, given, wanted });
            }
            let with_value = |(v, d): (&Vector, &Vec<Vector>)| [std::slice::from_ref(v), d.as_slice()].concat();
            let data: Vec<Vec<Vector>> = values.iter().zip(derivatives).map(with_value).collect();
            CurveShape::Polynomial(Polynomial::hermite(dimension, parameters, &data)?)
        }
        Method::CubicHermite(tangents) => {
            CurveShape::PiecewisePolynomial(cubic_hermite(dimension, parameters, values, tangents)?)
        }
        Method::CubicSpline(ends) => {
            CurveShape::PiecewisePolynomial(cubic_spline(dimension, parameters, values, ends)?)
        }
        Method::BSpline { degree, knots } => {
            CurveShape::BSpline(interpolate(dimension, parameters, values, *degree, knots)?)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Abscissae whose differences have no digits left: an error of 2 was told of this spline, and
    /// no fault.
    #[test]
    fn abscissae_of_subnormal_steps() {
        let third = Method::BSpline { degree: 3, knots: KnotChoice::Averaging };
        for method in [Method::CubicSpline(Ends::natural()), Method::CubicHermite(Tangents::Akima), third] {
            let x: Vec<f64> = (0..6).map(|i| f64::from(i) * 5e-324).collect();
            let points = Points::Graph { x, y: vec![1.0, -1.0, 1.0, -1.0, 1.0, -1.0] };
            let refused = through(&points, &method);
            assert!(matches!(refused, Err(CurveFault::TooClose { part: Part::X, index: 1, .. })), "{refused:?}");
        }
        // whatever else goes by, the curve passes its points
        for size in [1e-280, 1e-150, 1e-100, 1e100, 1e300] {
            let x: Vec<f64> = [0.0, 0.2, 0.3, 0.7, 0.9, 1.0].map(|x| x * size).to_vec();
            let points = Points::Graph { x, y: vec![1.0, -1.0, 1.0, -1.0, 1.0, -1.0] };
            for method in [Method::Lagrange, Method::CubicSpline(Ends::natural())] {
                if let Ok(found) = through(&points, &method) {
                    assert!(found.stability.interpolation_error < 1e-12, "{size} {method:?}");
                }
            }
        }
    }
}
