//! The condition number, in the 2-norm, of the equations behind a curve through points.
//!
//! For one polynomial: of the matrix of Vandermonde (Eqs. 13 and 14; for given derivatives the
//! confluent one) in powers of x as they are given, which is the paper's example of an
//! ill-conditioned problem. These equations are not solved here, the forms in use avoid them;
//! whoever writes the polynomial in powers does, and loses as many digits. The inverse is built
//! from cardinal polynomials in double-double, so that condition numbers far above 1e16 are figures
//! too. For splines: of the equations for the slopes, rows scaled to 2 on the diagonal. For
//! B-splines: of the collocation matrix.

use nalgebra::DMatrix;

use super::{
    barycentric::order_of_leja,
    figure::Absence,
    interpolate::{Collocation, chosen_knots},
    method::{Method, Nodes},
    newton::Newton,
    spline_system::SlopeMatrix,
};
use crate::space::Vector;
use flankfit_numerics::{Dd, cancel, condition::largest_singular_value};

/// The most conditions of a polynomial for which the number is computed: the work grows with their
/// cube.
pub const MOST_CONDITIONS: usize = 150;

/// The most nodes of a spline for which it is.
pub const MOST_NODES: usize = 5000;

pub(super) fn condition(nodes: &Nodes, method: &Method) -> Result<f64, Absence> {
    let parameters = &nodes.parameters;
    let within = |nodes: usize, most: usize| if nodes <= most { Ok(()) } else { Err(Absence::TooMany { nodes, most }) };
    let number = match method {
        Method::Lagrange | Method::Newton => {
            within(parameters.len(), MOST_CONDITIONS)?;
            vandermonde(parameters, &vec![1; parameters.len()])
        }
        Method::Hermite { derivatives } => {
            let counts: Vec<usize> = derivatives.iter().map(|d| d.len() + 1).collect();
            within(counts.iter().sum(), MOST_CONDITIONS)?;
            vandermonde(parameters, &counts)
        }
        Method::CubicHermite(_) => return Err(Absence::NoEquations),
        Method::CubicSpline(ends) => {
            within(parameters.len(), MOST_NODES)?;
            let matrix = SlopeMatrix::new(parameters, ends).ok_or(Absence::NoEquations)?;
            let norm = |solve: bool| {
                let apply = |transposed: bool| {
                    let matrix = &matrix;
                    move |x: &mut [f64]| {
                        if solve { matrix.solve(x, transposed) } else { matrix.multiply(x, transposed) }
                    }
                };
                largest_singular_value(matrix.size(), apply(false), apply(true))
            };
            product(norm(false), norm(true))
        }
        Method::BSpline { degree, knots } => {
            within(parameters.len(), MOST_NODES)?;
            let basis = chosen_knots(*degree, parameters, knots).map_err(|_| Absence::NotFinite)?;
            let equations = Collocation::new(basis, parameters).map_err(|_| Absence::NotFinite)?;
            let matrix = equations.matrix().map(Dd::to_f64);
            let lu = matrix.clone().factor().map_err(|_| Absence::NotFinite)?;
            let norm = largest_singular_value(
                parameters.len(),
                |x| x.copy_from_slice(&matrix.multiply(x)),
                |x| x.copy_from_slice(&matrix.multiply_transposed(x)),
            );
            let inverse = largest_singular_value(parameters.len(), |x| lu.solve(x), |x| lu.solve_transposed(x));
            product(norm, inverse)
        }
    };
    number.filter(|c| c.is_finite()).ok_or(Absence::NotFinite)
}

/// A condition number is at least 1, whatever rounding says.
fn product(norm: Option<f64>, inverse: Option<f64>) -> Option<f64> {
    Some((norm? * inverse?).max(1.0))
}

/// Condition of the matrix that turns coefficients of powers into values and derivatives,
/// `counts[i]` of them at node i.
fn vandermonde(nodes: &[f64], counts: &[usize]) -> Option<f64> {
    let size: usize = counts.iter().sum();
    let conditions = |i: usize| (0..counts[i]).map(move |order| (nodes[i], order));
    // the order only decides about rounding; rows may stand in any order
    let rows: Vec<(f64, usize)> = order_of_leja(nodes).into_iter().flat_map(conditions).collect();
    let mut matrix = DMatrix::zeros(size, size);
    for (i, (x, order)) in rows.iter().enumerate() {
        for j in *order..size {
            let falling = (j + 1 - order..=j).fold(1.0, |product, k| product * k as f64);
            matrix[(i, j)] = falling * x.powi((j - order) as i32);
        }
    }
    let mut inverse = DMatrix::zeros(size, size);
    let mut powers = vec![[Dd::ZERO; 3]; size];
    for first in (0..size).step_by(3) {
        cancel::checkpoint();
        let mut cardinal = Newton::default();
        for (i, (x, _)) in rows.iter().enumerate() {
            let unit = |k: usize| f64::from(u8::from(first + k == i));
            cardinal.push(*x, Vector::new(unit(0), unit(1), unit(2))).ok()?;
        }
        cardinal.taylor(0.0, &mut powers);
        for k in 0..3.min(size - first) {
            for j in 0..size {
                inverse[(j, first + k)] = powers[j][k].to_f64();
            }
        }
    }
    let [(norm, largest), (inverse, inverse_largest)] = [scaled_norm(matrix)?, scaled_norm(inverse)?];
    // the two largest entries may be far apart, their product is not
    Some(((norm * inverse) * largest * inverse_largest).max(1.0))
}

/// The norm of a matrix divided by its largest entry, and that entry.
fn scaled_norm(mut matrix: DMatrix<f64>) -> Option<(f64, f64)> {
    let largest = matrix.amax();
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    matrix /= largest;
    let apply = |x: &mut [f64], a: &DMatrix<f64>| {
        let mut y = vec![0.0; x.len()];
        for (column, x) in a.column_iter().zip(x.iter()) {
            y.iter_mut().zip(column.iter()).for_each(|(y, a)| *y += a * x);
        }
        x.copy_from_slice(&y);
    };
    let transposed = matrix.transpose();
    let norm = largest_singular_value(matrix.nrows(), |x| apply(x, &matrix), |x| apply(x, &transposed))?;
    Some((norm, largest))
}
