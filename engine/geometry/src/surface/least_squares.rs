//! B-spline surfaces near the nodes of a grid, by least squares without weights.
//!
//! On a full grid the problem separates, `X = X_u ⊗ X_v`: first every column of nodes is fitted
//! along u, then what comes out along v. Each axis is a banded matrix of m rows with degree + 1
//! entries, triangularised by rotations (O(m degree²)), which then serves all lines at once through
//! the seminormal equations `RᵀR x = Xᵀz`, corrected by their own residuals (Björck 1987): the
//! inner loops run over lines side by side (`least_squares_axis.rs`).
//!
//! Grids of up to [`FINE`] nodes are fitted with residuals in double-double, which gives the
//! coefficients all digits of a double; larger ones with residuals in double, which keeps them to
//! rounding of the largest.

use super::{
    BSplineSurface, check,
    grid::{NodeGrid, basis_of, check_degree},
    least_squares_axis::{AxisFit, Lines},
};
use crate::{BSplineBasis, curve::knots, space::Vector};
use flankfit_numerics::check::Faults;

/// Grids of more nodes are fitted in plain double.
pub const FINE: usize = 4096;

/// Source of the knots of an axis.
#[derive(Clone, Debug, PartialEq)]
pub enum AxisKnots {
    /// The full vector.
    Given(Vec<f64>),
    /// This many spans, each with about as many nodes (Piegl and Tiller, Eqs. 9.68 and 9.69).
    Spans(usize),
    /// This many spans of equal width.
    Uniform(usize),
}

/// The surface of these degrees with the least sum of squared distances (in its values) from the
/// nodes, and that sum.
///
/// ```
/// use flankfit_geometry::surface::{
///     NodeGrid, Surface,
///     least_squares::{AxisKnots, least_squares},
/// };
///
/// // Heights 0, 1, 0 over u, the same for both v: the line nearest to them is the constant 1/3,
/// // and the squares left over are 6/9 along each of the two lines.
/// let heights = [0.0, 0.0, 1.0, 1.0, 0.0, 0.0];
/// let grid = NodeGrid::heights(vec![0.0, 1.0, 2.0], vec![0.0, 1.0], &heights)?;
/// let one_span = [AxisKnots::Spans(1), AxisKnots::Spans(1)];
/// let (plane, sum_of_squares) = least_squares(&grid, [1, 1], one_span)?;
/// assert!((plane.value(1.5, 0.5).x - 1.0 / 3.0).abs() < 1e-14);
/// assert!((sum_of_squares - 4.0 / 3.0).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn least_squares(
    grid: &NodeGrid,
    degrees: [usize; 2],
    knots: [AxisKnots; 2],
) -> Result<(BSplineSurface, f64), Faults> {
    let [knots_u, knots_v] = knots;
    let bases = [basis(grid, 0, degrees[0], knots_u)?, basis(grid, 1, degrees[1], knots_v)?];
    let [rows, columns] = grid.parameters().each_ref().map(Vec::len);
    let fine = rows * columns <= FINE;
    let along_u = AxisFit::new(0, &bases[0], &grid.parameters()[0], fine)?;
    let along_v = AxisFit::new(1, &bases[1], &grid.parameters()[1], fine)?;
    let size = bases[0].size() * bases[1].size();
    let mut points = vec![Vector::zeros(); size];
    for c in 0..grid.dimension().count() {
        let nodes = Lines::of(rows, columns, |k| grid.values()[k][c]);
        let half = along_u.solve(&nodes).transposed();
        let whole = along_v.solve(&half).transposed();
        for (index, (point, x)) in points.iter_mut().zip(whole.entries()).enumerate() {
            if !x.is_finite() {
                return Err(check::not_representable(index));
            }
            point[c] = x;
        }
    }
    let sum = residual_sum(grid, &[&along_u, &along_v], &points, bases[1].size());
    let surface = BSplineSurface::new(bases, grid.dimension(), points, None);
    Ok((surface.map_err(|_| check::not_representable(0))?, sum))
}

fn basis(grid: &NodeGrid, axis: usize, degree: usize, knots: AxisKnots) -> Result<BSplineBasis, Faults> {
    let nodes = &grid.parameters()[axis];
    check_degree(axis, degree, nodes.len())?;
    let (low, high) = (nodes[0], nodes[nodes.len() - 1]);
    let spans_fault = |spans| check::spans(axis, spans, nodes.len(), degree);
    let checked = |spans: usize| {
        let fits = spans >= 1 && spans.saturating_add(degree) <= nodes.len();
        if fits { Ok(spans) } else { Err(spans_fault(spans)) }
    };
    let basis = match knots {
        AxisKnots::Given(knots) => basis_of(axis, degree, knots, nodes)?,
        AxisKnots::Spans(spans) => {
            let knots = knots::averaging_least_squares(degree, nodes, checked(spans)? + degree);
            basis_of(axis, degree, knots.map_err(|_| spans_fault(spans))?, nodes)?
        }
        AxisKnots::Uniform(spans) => {
            BSplineBasis::uniform(degree, checked(spans)?, low, high).map_err(check::knots(axis))?
        }
    };
    if basis.size() > nodes.len() {
        return Err(check::functions(axis, basis.size(), nodes.len()));
    }
    Ok(basis)
}

/// Sum of squared residuals over all coordinates.
fn residual_sum(grid: &NodeGrid, [along_u, along_v]: &[&AxisFit; 2], points: &[Vector], columns: usize) -> f64 {
    let mut sum = 0.0;
    for c in 0..grid.dimension().count() {
        let rows = points.len() / columns;
        let coefficients = Lines::of(columns, rows, |k| points[k % rows * columns + k / rows][c]);
        // values at the nodes' v for every function of u, then at their u: in the order of the
        // nodes
        let half = along_v.times(&coefficients).transposed();
        let fitted = along_u.times(&half);
        sum += grid.values().iter().zip(fitted.entries()).map(|(z, f)| (z[c] - f) * (z[c] - f)).sum::<f64>();
    }
    sum
}
