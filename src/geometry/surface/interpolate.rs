//! B-spline surfaces through every node of a grid.
//!
//! The equations of a grid separate: one banded matrix along u and one along v, each solved for all lines of nodes at once (de Boor,
//! A Practical Guide to Splines, ch. XVII). Everything runs in double-double and is rounded once.

use super::{
    BSplineSurface,
    grid::{GridFault, NodeGrid, basis_of, check_degree},
};
use crate::geometry::{BSplineBasis, curve::knots, space::Vector};
use crate::numerics::{
    Dd,
    banded::{Banded, BandedLu},
};

/// The surface of these degrees through all nodes of `grid`. Knots of an axis that are not given are means of neighbouring parameters
/// (Piegl and Tiller, Eq. 9.8); given ones number nodes + degree + 1.
pub fn interpolate(
    grid: &NodeGrid,
    degrees: [usize; 2],
    given: [Option<Vec<f64>>; 2],
) -> Result<BSplineSurface, GridFault> {
    let mut bases = Vec::with_capacity(2);
    for (axis, given) in given.into_iter().enumerate() {
        let nodes = &grid.parameters()[axis];
        check_degree(axis, degrees[axis], nodes.len())?;
        let knots = match given {
            Some(knots) => knots,
            None => knots::averaging(degrees[axis], nodes).map_err(|_| GridFault::TooFew {
                axis,
                given: nodes.len(),
                least: degrees[axis] + 1,
            })?,
        };
        let basis = basis_of(axis, degrees[axis], knots, nodes)?;
        if basis.size() != nodes.len() {
            return Err(GridFault::Functions { axis, functions: basis.size(), nodes: nodes.len() });
        }
        bases.push(basis);
    }
    let factors = [equations(0, &bases[0], &grid.parameters()[0])?, equations(1, &bases[1], &grid.parameters()[1])?];
    let points = solved(grid, &factors)?;
    let pair: [BSplineBasis; 2] = match <[_; 2]>::try_from(bases) {
        Ok(pair) => pair,
        Err(_) => return Err(GridFault::NoExtent { axis: 0 }),
    };
    BSplineSurface::new(pair, grid.dimension(), points, None).map_err(|_| GridFault::NotRepresentable { index: 0 })
}

/// Row i: the functions at node i, which see function i.
fn equations(axis: usize, basis: &BSplineBasis, nodes: &[f64]) -> Result<BandedLu<Dd>, GridFault> {
    let (p, n) = (basis.degree(), basis.size());
    let band = p.min(n - 1);
    let mut matrix = Banded::zeros(n, band, band);
    let mut values = vec![Dd::ZERO; p + 1];
    let support = |j: usize| (basis.knots()[j], basis.knots()[j + p + 1]);
    for (i, x) in nodes.iter().enumerate() {
        let first = basis.values(*x, &mut values);
        let sees = (first..=first + p).contains(&i) && values[i - first].hi > 0.0;
        if !sees {
            let (low, high) = support(i);
            return Err(GridFault::SchoenbergWhitney { axis, function: i, low, high });
        }
        for (j, value) in values.iter().enumerate() {
            // what lies beyond the band is 0 where node i sees function i: only the far ends of its row
            if value.hi != 0.0 {
                matrix.set(i, first + j, *value);
            }
        }
    }
    matrix.factor().map_err(|singular| {
        let (low, high) = support(singular.column);
        GridFault::Rank { axis, function: singular.column, low, high }
    })
}

/// Solves along u for every v, then along v for every function of u.
fn solved(grid: &NodeGrid, [along_u, along_v]: &[BandedLu<Dd>; 2]) -> Result<Vec<Vector>, GridFault> {
    let [rows, columns] = grid.parameters().each_ref().map(Vec::len);
    let mut points = vec![Vector::zeros(); rows * columns];
    for c in 0..grid.dimension().count() {
        let mut plane: Vec<Dd> = grid.values().iter().map(|p| Dd::from(p[c])).collect();
        let mut line = vec![Dd::ZERO; rows];
        for j in 0..columns {
            for (i, x) in line.iter_mut().enumerate() {
                *x = plane[i * columns + j];
            }
            along_u.solve(&mut line);
            for (i, x) in line.iter().enumerate() {
                plane[i * columns + j] = *x;
            }
        }
        plane.chunks_exact_mut(columns).for_each(|row| along_v.solve(row));
        for (index, (point, x)) in points.iter_mut().zip(plane).enumerate() {
            if !x.is_finite() {
                return Err(GridFault::NotRepresentable { index });
            }
            point[c] = x.to_f64();
        }
    }
    Ok(points)
}
