//! B-spline surfaces through every node of a grid.
//!
//! The equations of a grid separate: one banded matrix along u and one along v, each solved for all
//! lines of nodes at once (de Boor, A Practical Guide to Splines, ch. XVII). Everything runs in
//! double-double and is rounded once.

use super::{
    BSplineSurface, check,
    grid::{NodeGrid, basis_of, check_degree},
};
use crate::{
    BSplineBasis,
    curve::{
        interpolate::{Collocation, NoCollocation},
        knots,
    },
    space::Vector,
};
use flankfit_numerics::{Dd, cancel::Asking, check::Faults};

/// The surface of these degrees through all nodes of `grid`. Knots of an axis that are not given
/// are means of neighbouring parameters (Piegl and Tiller, Eq. 9.8); given ones number nodes +
/// degree + 1.
///
/// ```
/// use flankfit_geometry::surface::{NodeGrid, Surface, interpolate::interpolate};
///
/// // u² v is of degree 2 in u and 1 in v.
/// let (u, v) = (vec![0.0, 1.0, 3.0], vec![0.0, 2.0]);
/// let z: Vec<f64> = u.iter().flat_map(|u| v.iter().map(move |v| u * u * v)).collect();
/// let surface = interpolate(&NodeGrid::heights(u, v, &z)?, [2, 1], [None, None])?;
/// assert!((surface.value(2.0, 1.0).x - 4.0).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn interpolate(
    grid: &NodeGrid,
    degrees: [usize; 2],
    given: [Option<Vec<f64>>; 2],
) -> Result<BSplineSurface, Faults> {
    let mut systems = Vec::with_capacity(2);
    for (axis, given) in given.into_iter().enumerate() {
        let nodes = &grid.parameters()[axis];
        check_degree(axis, degrees[axis], nodes.len())?;
        let knots = match given {
            Some(knots) => knots,
            None => knots::averaging(degrees[axis], nodes)
                .map_err(|_| check::too_few(axis, nodes.len(), degrees[axis] + 1))?,
        };
        let basis = basis_of(axis, degrees[axis], knots, nodes)?;
        if basis.size() != nodes.len() {
            return Err(check::functions(axis, basis.size(), nodes.len()));
        }
        systems.push(equations(axis, basis, nodes)?);
    }
    let points = solved(grid, &systems)?;
    let bases = [systems[0].basis().clone(), systems[1].basis().clone()];
    BSplineSurface::new(bases, grid.dimension(), points, None).map_err(|_| check::not_representable(0))
}

/// The equations of one axis.
fn equations(axis: usize, basis: BSplineBasis, nodes: &[f64]) -> Result<Collocation, Faults> {
    let knots = basis.knots().to_vec();
    let p = basis.degree();
    let support = |function: usize| [knots[function], knots[function + p + 1]];
    Collocation::new(basis, nodes).map_err(|none| match none {
        NoCollocation::Unsupported { node, low, high, .. } => check::no_node(axis, node, [low, high]),
        NoCollocation::Singular { index } => check::undetermined(axis, index, support(index)),
        NoCollocation::Invalid(_) => check::functions(axis, knots.len() - p - 1, nodes.len()),
    })
}

/// Solves along u for every v, then along v for every function of u.
fn solved(grid: &NodeGrid, systems: &[Collocation]) -> Result<Vec<Vector>, Faults> {
    let [rows, columns] = grid.parameters().each_ref().map(Vec::len);
    let mut points = vec![Vector::zeros(); rows * columns];
    for c in 0..grid.dimension().count() {
        let mut plane: Vec<Dd> = grid.values().iter().map(|p| Dd::from(p[c])).collect();
        let mut line = vec![Dd::ZERO; rows];
        for j in (0..columns).asking(20 * line.len()) {
            for (i, x) in line.iter_mut().enumerate() {
                *x = plane[i * columns + j];
            }
            systems[0].solve(&mut line);
            for (i, x) in line.iter().enumerate() {
                plane[i * columns + j] = *x;
            }
        }
        plane.chunks_exact_mut(columns).for_each(|row| systems[1].solve(row));
        for (index, (point, x)) in points.iter_mut().zip(plane).enumerate() {
            if !x.is_finite() {
                return Err(check::not_representable(index));
            }
            point[c] = x.to_f64();
        }
    }
    Ok(points)
}
