//! The span of some columns of the largest model, in Q's coordinates.

use nalgebra::{DMatrix, DVector};

use crate::factor::{Factor, scaled_condition};
use flankfit_numerics::{Dd, lanes::Laned, qr_with_rhs, triangular};

/// Condition of the columns up to which doubles do.
const EASY: f64 = 1e4;

/// R and Qᵀ√Ωz of the largest model, in the precision that the condition of its columns requires.
pub(super) enum Triangle {
    Double(DMatrix<f64>, DVector<f64>),
    Exact(DMatrix<Dd>, DVector<Dd>),
}

/// The span of some columns.
pub(super) struct Subspace {
    /// Orthonormal columns.
    pub q: DMatrix<f64>,
    /// Increase of the residual sum of squares without each of the columns.
    pub rises: Vec<f64>,
}

impl Triangle {
    /// `None` where the columns depend on each other.
    pub(super) fn new(factor: &Factor) -> Option<Self> {
        let (_, condition) = scaled_condition(&factor.r)?;
        factor.working.as_ref()?;
        let qty = DVector::from_vec(factor.qty.clone());
        Some(match condition < EASY {
            true => Triangle::Double(factor.r.map(|x| x.to_f64()), qty.map(|x| x.to_f64())),
            false => Triangle::Exact(factor.r.clone(), qty),
        })
    }

    /// Time of a product in units of one of doubles.
    pub(super) fn cost(&self) -> usize {
        match self {
            Triangle::Double(..) => 1,
            Triangle::Exact(..) => 20,
        }
    }

    pub(super) fn subspace(&self, columns: &[usize]) -> Subspace {
        match self {
            Triangle::Double(r, b) => of(r, b, columns),
            Triangle::Exact(r, b) => of(r, b, columns),
        }
    }
}

fn of<T: Laned>(r: &DMatrix<T>, b: &DVector<T>, columns: &[usize]) -> Subspace {
    let (n, size) = (r.nrows(), columns.len());
    let some = DMatrix::from_fn(n, size, |i, j| r[(i, columns[j])]);
    let qr = qr_with_rhs(some.clone(), b.clone());
    let mut q = DMatrix::zeros(n, size);
    for i in 0..n {
        let mut row: Vec<T> = (0..size).map(|j| some[(i, j)]).collect();
        triangular::solve_upper_transposed(&qr.r, &mut row);
        row.iter().enumerate().for_each(|(j, x)| q[(i, j)] = x.to_f64());
    }
    let inverse = triangular::inverse_upper(&qr.r);
    let mut coefficients: Vec<T> = qr.qty.iter().copied().collect();
    triangular::solve_upper(&qr.r, &mut coefficients);
    let rise = |j: usize| {
        let length: f64 = (j..size).map(|k| inverse[(j, k)].to_f64().powi(2)).sum();
        coefficients[j].to_f64().powi(2) / length
    };
    Subspace { q, rises: (0..size).map(rise).collect() }
}
