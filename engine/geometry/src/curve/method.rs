//! Construction of a curve: points, a method, and the curve alone.

use super::{
    CurveShape, Ends, KnotChoice, Parametrization, Polynomial, Tangents, check, cubic_hermite, cubic_spline,
    interpolate,
};
use crate::space::{Dimension, Vector};
use flankfit_numerics::check::Faults;

/// Data that the curve has to pass through.
#[derive(Clone, Debug, PartialEq)]
pub enum Points {
    /// (x, y(x)): as many y as x. Polynomials take the x in any order, everything else ascending;
    /// no order is ever changed.
    Graph {
        /// Abscissae of the nodes.
        x: Vec<f64>,
        /// Ordinates, one for each x.
        y: Vec<f64>,
    },
    /// Points of plane or space, in the order in which the curve passes them.
    Space {
        /// The points; of the plane, the third coordinate is 0.
        points: Vec<Vector>,
        /// Whether they are points of the plane or of space.
        dimension: Dimension,
        /// How parameters are assigned to the points.
        parametrization: Parametrization,
    },
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
    Hermite {
        /// Derivatives of each node by rising order, from the first; empty lists where only the
        /// value is known.
        derivatives: Vec<Vec<Vector>>,
    },
    /// Cubics between the nodes with common tangents (Eq. 5).
    CubicHermite(Tangents),
    /// Cubics with continuous second derivative.
    CubicSpline(Ends),
    /// A B-spline of a degree from 1 (Eqs. 6 to 8).
    BSpline {
        /// Degree p, from 1.
        degree: usize,
        /// Knots, or the rule that places them.
        knots: KnotChoice,
    },
}

/// Points as the methods take them: parameters and values.
pub(super) struct Nodes {
    pub dimension: Dimension,
    pub parameters: Vec<f64>,
    pub values: Vec<Vector>,
}

pub(super) fn nodes(points: &Points) -> Result<Nodes, Faults> {
    match points {
        Points::Graph { x, y } => {
            check::count("values", y.len(), x.len())?;
            let values = y.iter().map(|y| Vector::new(*y, 0.0, 0.0)).collect();
            Ok(Nodes { dimension: Dimension::Graph, parameters: x.clone(), values })
        }
        Points::Space { points, dimension, parametrization } => {
            let parameters = parametrization.parameters(points).map_err(|faults| faults.within("values"))?;
            Ok(Nodes { dimension: *dimension, parameters, values: points.clone() })
        }
    }
}

pub(super) fn shape(nodes: &Nodes, method: &Method) -> Result<CurveShape, Faults> {
    let Nodes { dimension, parameters, values } = nodes;
    let dimension = *dimension;
    Ok(match method {
        Method::Lagrange => {
            CurveShape::Polynomial(Polynomial::lagrange(dimension, parameters.clone(), values.clone())?)
        }
        Method::Newton => CurveShape::Polynomial(Polynomial::newton(dimension, parameters, values)?),
        Method::Hermite { derivatives } => {
            check::count("method.derivatives", derivatives.len(), values.len())?;
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
