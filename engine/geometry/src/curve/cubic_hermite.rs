//! Piecewise cubic Hermite curves (Eq. 5): values and tangents at the nodes, one cubic between each
//! two.
//!
//! Continuous with the first derivative, not with the second. The paper calls "stable and accurate
//! evaluation of the necessary gradients" the open problem; [`Tangents`] lists the rules that are
//! in use. All rules work on each coordinate alone. Secants and coefficients are computed in
//! double-double.

use super::{
    check,
    piecewise::PiecewisePolynomial,
    tangents::{Tangents, secants, slopes},
};
use crate::space::{Dimension, Vector};
use flankfit_numerics::{Dd, check::Faults};

/// The curve through `values` at the ascending `nodes`, at least two.
///
/// ```
/// use flankfit_geometry::{
///     curve::{Curve, Tangents, cubic_hermite},
///     space::{Dimension, Vector},
/// };
///
/// // A step: the monotone rule keeps the flat runs flat.
/// let heights = [0.0, 0.0, 1.0, 1.0].map(|y| Vector::new(y, 0.0, 0.0));
/// let nodes = [0.0, 1.0, 2.0, 3.0];
/// let step = cubic_hermite(Dimension::Graph, &nodes, &heights, &Tangents::Monotone)?;
/// assert_eq!([step.value(0.5).x, step.value(1.5).x, step.value(2.5).x], [0.0, 0.5, 1.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn cubic_hermite(
    dimension: Dimension,
    nodes: &[f64],
    values: &[Vector],
    tangents: &Tangents,
) -> Result<PiecewisePolynomial, Faults> {
    check(nodes, values)?;
    let slopes = match tangents {
        Tangents::Given(given) => {
            check::count("method.values", given.len(), nodes.len())?;
            check::points("method.values", given)?;
            given.iter().map(|v| [v.x, v.y, v.z].map(Dd::from)).collect()
        }
        rule => slopes(rule, nodes, values),
    };
    pieces(dimension, nodes, values, &slopes)
}

/// Nodes ascend, values are finite and as many.
pub(super) fn check(nodes: &[f64], values: &[Vector]) -> Result<(), Faults> {
    check::at_least("nodes", nodes.len(), 2)?;
    check::count("values", values.len(), nodes.len())?;
    check::ascending("nodes", nodes)?;
    check::points("values", values)
}

/// The cubics with these values and slopes at the nodes.
pub(super) fn pieces(
    dimension: Dimension,
    nodes: &[f64],
    values: &[Vector],
    slopes: &[[Dd; 3]],
) -> Result<PiecewisePolynomial, Faults> {
    let mut coefficients = Vec::with_capacity(4 * nodes.len());
    for (i, secant) in secants(nodes, values).iter().enumerate() {
        let width = Dd::diff(nodes[i + 1], nodes[i]);
        let mut piece = [values[i], Vector::zeros(), Vector::zeros(), Vector::zeros()];
        for k in 0..3 {
            let (left, right, chord) = (slopes[i][k], slopes[i + 1][k], secant[k]);
            piece[1][k] = left.to_f64();
            piece[2][k] = ((chord * 3.0 - left - left - right) / width).to_f64();
            piece[3][k] = ((left + right - chord - chord) / width / width).to_f64();
        }
        coefficients.extend(piece);
    }
    PiecewisePolynomial::new(dimension, nodes.to_vec(), 3, coefficients)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::Curve;

    #[test]
    fn given_tangents_are_met() {
        let nodes = [0.0, 1.0, 3.0];
        let values = [[0., 0.], [1., 2.], [4., 1.]].map(|[x, y]| Vector::new(x, y, 0.0));
        let tangents = [[1., 1.], [0., -2.], [3., 0.5]].map(|[x, y]| Vector::new(x, y, 0.0));
        let given = Tangents::Given(tangents.to_vec());
        let curve = cubic_hermite(Dimension::Plane, &nodes, &values, &given).unwrap();
        for i in 0..3 {
            let jet = curve.jet(nodes[i]);
            assert!((jet[0] - values[i]).amax() < 1e-15 && (jet[1] - tangents[i]).amax() < 1e-14);
        }
    }

    #[test]
    fn invalid_input_is_refused() {
        let values = [0.0, 1.0, 2.0].map(|y| Vector::new(y, 0.0, 0.0));
        let new = |nodes: &[f64], t: &Tangents| {
            cubic_hermite(Dimension::Graph, nodes, &values, t).unwrap_err().list()[0].clone()
        };
        assert_eq!(new(&[0.0, 2.0, 1.0], &Tangents::Akima).path, "nodes[2]");
        assert_eq!(new(&[0.0, 2.0], &Tangents::Akima).path, "values");
        let fault = new(&[0.0, 1.0, 2.0], &Tangents::Given(vec![Vector::zeros(); 2]));
        assert_eq!((&*fault.path, &*fault.message), ("method.values", "2 are given where 3 are needed"));
        let fault = new(&[0.0, 1.0, 2.0], &Tangents::Given(vec![Vector::zeros(), Vector::x() * f64::NAN, values[0]]));
        assert_eq!(fault.path, "method.values[1]");
    }
}
