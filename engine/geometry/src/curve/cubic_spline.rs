//! Cubic splines: the smoothest curve through the nodes, continuous with its second derivative.
//!
//! The unknowns are the slopes at the nodes; continuity of the second derivative at an inner node
//! gives one equation of three unknowns each, and what the ends ask for two more. The system is
//! solved in double-double, coordinates together.

use super::{
    check,
    cubic_hermite::{self, pieces},
    ends::{End, Ends},
    piecewise::PiecewisePolynomial,
    spline_system::{Slopes, continuity, inner_system, open_system, widths},
    tangents::secants,
};
use crate::space::{Dimension, Vector};
use flankfit_numerics::{Banded, BandedLu, Dd, check::Faults, words::Shown};

/// Values at the two ends of a period may differ by this part of the largest.
const PERIOD: f64 = 8.0 * f64::EPSILON;

/// The spline through `values` at the ascending `nodes`, at least two.
///
/// ```
/// use flankfit_geometry::{
///     curve::{Curve, Ends, cubic_spline},
///     space::{Dimension, Vector},
/// };
///
/// // Without conditions of its own at the ends, the spline through points of a cubic is that
/// // cubic.
/// let cubes = [0.0, 1.0, 8.0, 27.0].map(|y| Vector::new(y, 0.0, 0.0));
/// let nodes = [0.0, 1.0, 2.0, 3.0];
/// let spline = cubic_spline(Dimension::Graph, &nodes, &cubes, &Ends::not_a_knot())?;
/// assert!((spline.value(1.5).x - 3.375).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn cubic_spline(
    dimension: Dimension,
    nodes: &[f64],
    values: &[Vector],
    ends: &Ends,
) -> Result<PiecewisePolynomial, Faults> {
    cubic_hermite::check(nodes, values)?;
    let secants = secants(nodes, values);
    let slopes = match ends {
        Ends::Periodic => {
            let last = values.len() - 1;
            let difference = (values[last] - values[0]).amax();
            let largest = values.iter().fold(0.0f64, |m, v| m.max(v.amax()));
            if !(difference <= PERIOD * largest) {
                return Err(Faults::one(
                    format_args!("values[{last}]"),
                    format_args!(
                        "a periodic curve ends where it starts, but node {last} differs from node 0 by {}",
                        Shown(difference)
                    ),
                ));
            }
            periodic(nodes, &secants)?
        }
        Ends::Each { start, end } => {
            for (place, end) in [("method.ends.start", start), ("method.ends.end", end)] {
                if let End::Slope(given) | End::SecondDerivative(given) = end {
                    check::points(place, std::slice::from_ref(given))?;
                }
            }
            open(nodes, &secants, start, end)?
        }
    };
    pieces(dimension, nodes, values, &slopes)
}

fn factor(a: Banded<Dd>) -> Result<BandedLu<Dd>, Faults> {
    a.factor().map_err(|fault| check::singular(fault.column))
}

/// Solves for all three coordinates.
fn solve(lu: &BandedLu<Dd>, b: &[[Dd; 3]]) -> Slopes {
    let mut slopes = vec![[Dd::ZERO; 3]; b.len()];
    for k in 0..3 {
        let mut one: Vec<Dd> = b.iter().map(|b| b[k]).collect();
        lu.solve(&mut one);
        slopes.iter_mut().zip(one).for_each(|(s, x)| s[k] = x);
    }
    slopes
}

fn open(nodes: &[f64], secants: &[[Dd; 3]], start: &End, end: &End) -> Result<Slopes, Faults> {
    let (a, b) = open_system(nodes, secants, start, end);
    Ok(solve(&factor(a)?, &b))
}

fn periodic(nodes: &[f64], secants: &[[Dd; 3]]) -> Result<Slopes, Faults> {
    let n = nodes.len();
    if n == 2 {
        // the one period that has equal values at its only two nodes
        return Ok(vec![[Dd::ZERO; 3]; 2]);
    }
    let h = widths(nodes);
    let (a, b, border) = inner_system(nodes, secants);
    let lu = factor(a)?;
    // slopes of inner nodes are `free − shape · slope of node 0`
    let free = solve(&lu, &b);
    let mut shape = border;
    lu.solve(&mut shape);
    let m = n - 2;
    let (row, right) = continuity([h[m], h[0]], secants[m], secants[0]);
    let pivot = row[1] - row[0] * shape[m - 1] - row[2] * shape[0];
    let first = [0, 1, 2].map(|k| (right[k] - row[0] * free[m - 1][k] - row[2] * free[0][k]) / pivot);
    let inner = (0..m).map(|i| [0, 1, 2].map(|k| free[i][k] - shape[i] * first[k]));
    Ok(std::iter::once(first).chain(inner).chain(std::iter::once(first)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::Curve;

    fn graph(y: &[f64]) -> Vec<Vector> {
        y.iter().map(|y| Vector::new(*y, 0.0, 0.0)).collect()
    }

    /// With ends taken from the cubic itself, every kind of end gives the cubic back, down to two
    /// nodes.
    #[test]
    fn a_cubic_is_its_own_spline() {
        let cubic = |x: f64| [2.0 - x + 0.5 * x * x * x, -1.0 + 1.5 * x * x, 3.0 * x, 3.0];
        let of = |order: usize, x: f64| Vector::new(cubic(x)[order], 0.0, 0.0);
        for nodes in [vec![-1.0, 2.0], vec![-1.0, 0.5, 2.0], vec![-1.0, -0.5, 1.0, 1.25, 2.0]] {
            let values: Vec<Vector> = nodes.iter().map(|x| of(0, *x)).collect();
            let (slope, second) = (|x| End::Slope(of(1, x)), |x| End::SecondDerivative(of(2, x)));
            let mut all = vec![(slope(-1.0), slope(2.0)), (second(-1.0), second(2.0)), (slope(-1.0), second(2.0))];
            if nodes.len() > 2 {
                all.extend([(End::NotAKnot, slope(2.0)), (second(-1.0), End::NotAKnot)]);
            }
            if nodes.len() > 3 {
                all.push((End::NotAKnot, End::NotAKnot));
            }
            for (start, end) in all {
                let spline = cubic_spline(Dimension::Graph, &nodes, &values, &Ends::Each { start, end }).unwrap();
                for t in [-1.0, -0.7, 0.6, 1.9] {
                    for (got, exact) in spline.jet(t).iter().zip(cubic(t)) {
                        assert!((got.x - exact).abs() < 1e-14, "{nodes:?} {start:?} {end:?} {t}");
                    }
                }
            }
        }
    }

    #[test]
    fn too_few_nodes_for_not_a_knot() {
        let new = |x: &[f64], y: &[f64], ends: Ends| cubic_spline(Dimension::Graph, x, &graph(y), &ends).unwrap();
        assert_eq!(new(&[1.0, 3.0], &[1.0, 5.0], Ends::not_a_knot()).value(2.5).x, 4.0);
        assert_eq!(new(&[0.0, 1.0, 3.0], &[0.0, 1.0, 9.0], Ends::not_a_knot()).value(2.0).x, 4.0);
        assert_eq!(new(&[0.0, 1.0], &[2.0, 2.0], Ends::Periodic).value(0.5).x, 2.0);
        let start = End::Slope(Vector::zeros());
        let parabola = new(&[0.0, 2.0], &[0.0, 4.0], Ends::Each { start, end: End::NotAKnot });
        assert_eq!(parabola.value(1.0).x, 1.0);
    }

    #[test]
    fn a_period_closes() {
        let (x, y) = ([0.0, 1.0, 2.5, 3.0, 4.0], [1.0, 3.0, -1.0, 0.5, 1.0]);
        for n in [3, 5] {
            let mut y = y[..n].to_vec();
            y[n - 1] = 1.0;
            let spline = cubic_spline(Dimension::Graph, &x[..n], &graph(&y), &Ends::Periodic).unwrap();
            let (start, end) = (spline.jet(0.0), spline.jet(x[n - 1]));
            for k in 0..3 {
                assert!((start[k] - end[k]).amax() < 1e-13, "{n} {k}");
            }
        }
    }

    #[test]
    fn invalid_input_is_refused() {
        let fault = cubic_spline(Dimension::Graph, &[0.0, 1.0, 2.0], &graph(&[0.0, 1.0, 0.5]), &Ends::Periodic);
        assert_eq!(fault.unwrap_err().list()[0].path, "values[2]");
        let ends = Ends::clamped(Vector::zeros(), Vector::x() * f64::INFINITY);
        let fault = cubic_spline(Dimension::Graph, &[0.0, 1.0], &graph(&[0.0, 1.0]), &ends).unwrap_err();
        assert_eq!(fault.list()[0].path, "method.ends.end[0]");
        assert!(cubic_spline(Dimension::Graph, &[0.0], &graph(&[0.0]), &Ends::natural()).is_err());
    }

    #[test]
    fn the_matrix_and_its_inverse() {
        let nodes = [0.0, 0.5, 2.0, 3.0, 3.5, 6.0];
        for ends in [Ends::natural(), Ends::not_a_knot(), Ends::Periodic] {
            let matrix = crate::curve::spline_system::SlopeMatrix::new(&nodes, &ends).unwrap();
            for transposed in [false, true] {
                let x: Vec<f64> = (0..matrix.size()).map(|i| 1.0 + i as f64).collect();
                let mut y = x.clone();
                matrix.multiply(&mut y, transposed);
                matrix.solve(&mut y, transposed);
                assert!(x.iter().zip(&y).all(|(a, b)| (a - b).abs() < 1e-13), "{ends:?} {y:?}");
            }
        }
    }
}
