//! Grids of nodes, (uᵢ, vⱼ, zᵢⱼ) or points of space in rows: what they are checked for, and which
//! parameters points get.

use super::check;
use crate::{
    BSplineBasis,
    curve::Parametrization,
    space::{Dimension, HIGHEST_DEGREE, Vector},
};
use flankfit_numerics::{cancel, check::Faults, words::counted};

/// Values at all crossings of two lists of parameters, v running fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeGrid {
    parameters: [Vec<f64>; 2],
    dimension: Dimension,
    values: Vec<Vector>,
}

impl NodeGrid {
    /// Heights z(u, v): `z` has one number for every (u, v), v running fastest; parameters are
    /// finite and ascend strictly.
    pub fn heights(u: Vec<f64>, v: Vec<f64>, z: &[f64]) -> Result<Self, Faults> {
        let values = z.iter().map(|z| Vector::new(*z, 0.0, 0.0)).collect();
        Self::checked([u, v], Dimension::Graph, values)
    }

    /// Points of space at given parameters, v running fastest.
    pub fn points(u: Vec<f64>, v: Vec<f64>, points: Vec<Vector>) -> Result<Self, Faults> {
        Self::checked([u, v], Dimension::Space, points)
    }

    /// Rows of points of space (each at one u); their parameters from 0 to 1 are the mean of those
    /// of all rows, and of all columns. Lines whose points are all one, as at the tip of a
    /// three-sided patch, have no say.
    pub fn rows(rows: &[Vec<Vector>], parametrization: Parametrization) -> Result<Self, Faults> {
        let columns = rows.first().map_or(0, Vec::len);
        check::even_rows(rows.iter().map(Vec::len), columns)?;
        let count = [rows.len(), columns];
        enough(count)?;
        let values = rows.concat();
        finite(&values, columns)?;
        let point = |axis: usize, line: usize, k: usize| if axis == 0 { rows[k][line] } else { rows[line][k] };
        let mut parameters = [Vec::new(), Vec::new()];
        for axis in 0..2 {
            let (mut sums, mut lines) = (vec![0.0; count[axis]], 0.0);
            for line in 0..count[1 - axis] {
                cancel::checkpoint();
                let points: Vec<Vector> = (0..count[axis]).map(|k| point(axis, line, k)).collect();
                if points.iter().all(|p| *p == points[0]) {
                    continue;
                }
                let found = parametrization.along(&points).map_err(|k| {
                    let (row, column) = if axis == 0 { (k, line) } else { (line, k) };
                    Faults::one(
                        format_args!("nodes.points[{row}][{column}]"),
                        format_args!(
                            "the point ({row}, {column}) and the one before it along {} coincide, so no parameter \
                             lies between them",
                            check::AXES[axis]
                        ),
                    )
                })?;
                sums.iter_mut().zip(found).for_each(|(sum, t)| *sum += t);
                lines += 1.0;
            }
            if lines == 0.0 {
                let message = format_args!("along {} all points of every line coincide", check::AXES[axis]);
                return Err(Faults::one("nodes.points", message));
            }
            parameters[axis] = sums.iter().map(|sum| sum / lines).collect();
        }
        Self::checked(parameters, Dimension::Space, values)
    }

    fn checked(parameters: [Vec<f64>; 2], dimension: Dimension, values: Vec<Vector>) -> Result<Self, Faults> {
        let count = parameters.each_ref().map(Vec::len);
        enough(count)?;
        for (axis, places) in parameters.iter().enumerate() {
            check::ascending(axis, places)?;
        }
        let [rows, columns] = count;
        if values.len() != rows * columns {
            let given = counted(values.len(), "value", "values");
            return Err(Faults::one("nodes.z", format_args!("{given} for {rows} × {columns} nodes")));
        }
        finite(&values, columns)?;
        Ok(NodeGrid { parameters, dimension, values })
    }

    /// The parameters along u and v.
    pub fn parameters(&self) -> &[Vec<f64>; 2] {
        &self.parameters
    }

    /// Heights or points of space.
    pub fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// The values, v running fastest.
    pub fn values(&self) -> &[Vector] {
        &self.values
    }
}

fn enough([rows, columns]: [usize; 2]) -> Result<(), Faults> {
    for (axis, given) in [rows, columns].into_iter().enumerate() {
        check::at_least(axis, given, 2)?;
    }
    Ok(())
}

fn finite(values: &[Vector], columns: usize) -> Result<(), Faults> {
    // all of them without a branch: grids are large, and errors rare
    if values.iter().fold(true, |sound, p| sound & p.x.is_finite() & p.y.is_finite() & p.z.is_finite()) {
        return Ok(());
    }
    match values.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        Some(at) => {
            let (row, column) = (at / columns, at % columns);
            Err(Faults::one(
                format_args!("nodes.z[{row}][{column}]"),
                format_args!("the value at ({row}, {column}) is not finite"),
            ))
        }
        None => Ok(()),
    }
}

/// Refuses degrees outside 1 to [`HIGHEST_DEGREE`] or that `nodes` cannot carry.
pub(super) fn check_degree(axis: usize, degree: usize, nodes: usize) -> Result<(), Faults> {
    if !(1..=HIGHEST_DEGREE).contains(&degree) {
        return Err(check::degree(axis, degree, HIGHEST_DEGREE));
    }
    check::at_least(axis, nodes, degree + 1)
}

/// Checks given knots, and that no node lies outside of their domain.
pub(super) fn basis_of(axis: usize, degree: usize, knots: Vec<f64>, nodes: &[f64]) -> Result<BSplineBasis, Faults> {
    let basis = BSplineBasis::new(degree, knots).map_err(check::knots(axis))?;
    let (low, high) = basis.domain();
    match nodes.iter().position(|x| !(low <= *x && *x <= high)) {
        Some(index) => Err(check::out_of_domain(axis, index, nodes[index], [low, high])),
        None => Ok(basis),
    }
}
