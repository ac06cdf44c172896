//! The functions on one axis.

use nalgebra::DMatrix;

use flankfit_geometry::{
    BSplineBasis, Mapping,
    polynomial::{self, Family},
};
use flankfit_numerics::{Dd, Real};

/// The functions on one axis.
#[derive(Clone)]
pub(crate) enum Axis {
    Polynomial { family: Family, mapping: Mapping, size: usize },
    Spline(BSplineBasis),
}

impl Axis {
    pub(crate) fn size(&self) -> usize {
        match self {
            Axis::Polynomial { size, .. } => *size,
            Axis::Spline(basis) => basis.size(),
        }
    }

    /// Every working function at `x`, zeros included.
    pub(crate) fn row<T: Real>(&self, x: f64, out: &mut [T]) {
        match self {
            Axis::Polynomial { mapping, .. } => polynomial::chebyshev_values(mapping.map::<T>(x), out),
            Axis::Spline(basis) => {
                let p = basis.degree();
                out.fill(T::of(0.0));
                let mut local = vec![T::of(0.0); p + 1];
                let first = basis.values(x, &mut local);
                out[first..=first + p].copy_from_slice(&local);
            }
        }
    }

    /// Values and first derivatives of the *caller's* functions at `x`.
    pub(crate) fn caller_row(&self, x: f64, values: &mut [f64], derivatives: &mut [f64]) {
        match self {
            Axis::Polynomial { family, .. } => polynomial::values_and_derivatives(*family, x, values, derivatives),
            Axis::Spline(basis) => {
                self.row(x, values);
                derivatives.fill(0.0);
                let mut local = vec![0.0; basis.degree() + 1];
                let first = basis.derivatives(x, &mut local);
                derivatives[first..first + local.len()].copy_from_slice(&local);
            }
        }
    }

    /// The change of basis of this axis.
    pub(crate) fn change(&self) -> DMatrix<Dd> {
        match self {
            Axis::Polynomial { family, mapping, size } => polynomial::change_of_basis(*family, *mapping, *size),
            Axis::Spline(basis) => identity(basis.size()),
        }
    }
}

fn identity(n: usize) -> DMatrix<Dd> {
    DMatrix::from_fn(n, n, |i, j| if i == j { Dd::ONE } else { Dd::ZERO })
}
