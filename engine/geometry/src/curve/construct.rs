//! Construction of all curves through points: from points and a method to the curve with a report
//! on its stability.

use super::{
    Curve, CurveShape,
    method::{Method, Nodes, Points, nodes, shape},
    stability::{Stability, stability},
};
use flankfit_numerics::{check::Faults, words::Shown};

/// A curve through points.
#[derive(Clone, Debug, PartialEq)]
pub struct Constructed {
    /// The curve through the points.
    pub shape: CurveShape,
    /// Parameters of the points on the curve: x of a graph, else one parameter per point.
    pub parameters: Vec<f64>,
    /// How far the curve can be trusted between the points.
    pub stability: Stability,
}

/// The curve through the points, with its stability.
///
/// ```
/// use flankfit_geometry::curve::{Curve, Method, Points, through};
///
/// // Three equidistant nodes: the parabola x² + 1, whose Lebesgue constant is 5/4.
/// let points = Points::Graph { x: vec![0.0, 1.0, 2.0], y: vec![1.0, 2.0, 5.0] };
/// let made = through(&points, &Method::Lagrange)?;
/// assert!((made.shape.value(1.5).x - 3.25).abs() < 1e-14);
/// assert!((made.stability.lebesgue.unwrap().constant - 1.25).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn through(points: &Points, method: &Method) -> Result<Constructed, Faults> {
    let (nodes, shape) = nodes_and_shape(points, method)?;
    let stability = stability(&nodes, method, &shape);
    Ok(Constructed { shape, parameters: nodes.parameters, stability })
}

/// How far, in parts of the largest value, a curve may miss its nodes.
const MISS: f64 = 1e-3;

/// Refuses a curve through points that rounding has led past them.
fn verify(nodes: &Nodes, shape: &CurveShape) -> Result<(), Faults> {
    let largest = nodes.values.iter().fold(0.0f64, |most, value| most.max(value.amax()));
    for (index, (t, value)) in nodes.parameters.iter().zip(&nodes.values).enumerate() {
        let miss = (shape.value(*t) - value).amax();
        if !(miss <= MISS * largest) {
            return Err(Faults::one(
                "",
                format_args!("by rounding alone the curve misses node {index} by {}", Shown(miss)),
            ));
        }
    }
    Ok(())
}

/// The curve alone, with the parameters of the points.
///
/// ```
/// use flankfit_geometry::curve::{Curve, Ends, Method, Points, construct::shape_through};
///
/// // A natural spline over 0, 1, 0: its second derivative in the middle is −3, and between the
/// // first two nodes it is y = 3x/2 − x³/2.
/// let points = Points::Graph { x: vec![0.0, 1.0, 2.0], y: vec![0.0, 1.0, 0.0] };
/// let (spline, parameters) = shape_through(&points, &Method::CubicSpline(Ends::natural()))?;
/// assert_eq!(parameters, [0.0, 1.0, 2.0]);
/// assert!((spline.value(0.5).x - 0.6875).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn shape_through(points: &Points, method: &Method) -> Result<(CurveShape, Vec<f64>), Faults> {
    let (nodes, shape) = nodes_and_shape(points, method)?;
    Ok((shape, nodes.parameters))
}

/// Places errors of nodes and values where the points have these.
fn nodes_and_shape(points: &Points, method: &Method) -> Result<(Nodes, CurveShape), Faults> {
    let made = || {
        let nodes = nodes(points)?;
        let shape = shape(&nodes, method)?;
        verify(&nodes, &shape)?;
        Ok((nodes, shape))
    };
    let [x, y] = match points {
        Points::Graph { .. } => ["points.x", "points.y"],
        Points::Space { .. } => ["points.xyz"; 2],
    };
    made().map_err(|faults: Faults| faults.moved("nodes", x).moved("values", y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::{Ends, KnotChoice, Tangents};

    /// Abscissae whose differences have no digits left: this spline had an error of 2, and
    /// no error was reported.
    #[test]
    fn abscissae_of_subnormal_steps() {
        let third = Method::BSpline { degree: 3, knots: KnotChoice::Averaging };
        for method in [Method::CubicSpline(Ends::natural()), Method::CubicHermite(Tangents::Akima), third] {
            let x: Vec<f64> = (0..6).map(|i| f64::from(i) * 5e-324).collect();
            let points = Points::Graph { x, y: vec![1.0, -1.0, 1.0, -1.0, 1.0, -1.0] };
            let fault = through(&points, &method).unwrap_err();
            assert_eq!(fault.list()[0].path, "points.x[1]");
            assert!(fault.to_string().contains("which is too close for double precision"), "{fault}");
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
