//! The scaled columns in which eigenvalues, λ* and bounds are understood: `X̃ = X P`.
//!
//! * `unit_length`: every column divided by its length. * `none`: as they are (the paper's).
//! * `standardized`: columns centred and divided by √mean((x−x̄)²); the constant drops out of the
//!   analysis and is estimated without penalty, so `X̃` has one column less.

use nalgebra::DMatrix;

use crate::{
    design::{Basis, Design},
    error::FitError,
    factor::Factor,
    spec::Scaling,
};
use flankfit_numerics::{Dd, check::Faults};

/// The squared Frobenius norm of δX̃ for unit moves, from the sums over nodes of each column.
pub(crate) fn of_scaled(sums: &[f64], columns: &ScaledColumns) -> f64 {
    columns.kept.iter().zip(&columns.scale).map(|(&j, s)| sums[j] / (s.to_f64() * s.to_f64())).sum()
}

/// `P` and what it leaves aside.
pub(crate) struct ScaledColumns {
    /// `R P` in Q's coordinates: n rows, one column for each scaled column.
    pub matrix: DMatrix<Dd>,
    /// Index of the coefficient of each scaled column.
    pub kept: Vec<usize>,
    /// Divisor of each scaled column.
    pub scale: Vec<Dd>,
    /// The unpenalised constant of `standardized`.
    pub constant: Option<Constant>,
}

/// The constant column, left out of the analysis.
pub(crate) struct Constant {
    /// Index of the coefficient.
    pub index: usize,
    /// Mean of each kept column in units of the constant column.
    pub means: Vec<Dd>,
    /// Squared length of the constant column.
    pub length_squared: f64,
}

/// Squared length of a column, `R`'s columns being those of `X` seen in Q's coordinates.
fn length_squared(matrix: &DMatrix<Dd>, column: usize) -> Dd {
    matrix.column(column).iter().fold(Dd::ZERO, |sum, &x| sum + x * x)
}

/// The caller's columns `X = W T` in Q's coordinates.
pub(crate) fn caller_columns(factor: &Factor) -> DMatrix<Dd> {
    match factor.separable.as_ref().map(|separable| &separable.axes) {
        Some(axes) => crate::factor::kronecker(
            &flankfit_numerics::triangular::multiply_upper(&axes.u.r, &axes.u.change),
            &flankfit_numerics::triangular::multiply_upper(&axes.v.r, &axes.v.change),
        ),
        None => flankfit_numerics::triangular::multiply_upper(&factor.r, &factor.change),
    }
}

impl ScaledColumns {
    /// Scales the caller's columns `caller` (in Q's coordinates) as asked; `weight` is Σw.
    pub(crate) fn new(design: &Design, caller: &DMatrix<Dd>, scaling: Scaling, weight: f64) -> Result<Self, FitError> {
        let n = caller.ncols();
        match scaling {
            Scaling::None | Scaling::UnitLength => {
                let scale: Vec<Dd> = (0..n)
                    .map(|j| match scaling {
                        Scaling::UnitLength => positive(length_squared(caller, j).sqrt()),
                        _ => Dd::ONE,
                    })
                    .collect();
                let mut matrix = caller.clone();
                for (mut column, s) in matrix.column_iter_mut().zip(&scale) {
                    if *s != Dd::ONE {
                        let inverse = Dd::ONE / *s;
                        column.iter_mut().for_each(|x| *x *= inverse);
                    }
                }
                Ok(ScaledColumns { matrix, kept: (0..n).collect(), scale, constant: None })
            }
            Scaling::Standardized => standardized(design, caller, weight),
        }
    }
}

fn positive(length: Dd) -> Dd {
    if length > Dd::ZERO { length } else { Dd::ONE }
}

/// Number of scaled columns. Refuses models with an inadmissible number of columns; whether a
/// posted column is constant depends on the nodes.
pub(crate) fn scaled_size(design: &Design, scaling: Scaling) -> Result<usize, Faults> {
    let n = design.size();
    match scaling {
        Scaling::None | Scaling::UnitLength => Ok(n),
        Scaling::Standardized => {
            if matches!(design.basis, Basis::Product { .. }) {
                constant_of(design)?;
            }
            match n {
                0 | 1 => Err(Faults::one("scaling", "`standardized` leaves one column aside, and there is no other")),
                n => Ok(n - 1),
            }
        }
    }
}

fn constant_of(design: &Design) -> Result<usize, Faults> {
    design.constant.ok_or_else(|| {
        Faults::one("scaling", "`standardized` needs exactly one constant column or term, which it leaves unpenalised")
    })
}

fn standardized(design: &Design, caller: &DMatrix<Dd>, weight: f64) -> Result<ScaledColumns, FitError> {
    scaled_size(design, Scaling::Standardized)?;
    let index = constant_of(design)?;
    let n = caller.ncols();
    let kept: Vec<usize> = (0..n).filter(|&j| j != index).collect();
    let own = length_squared(caller, index);
    let mut matrix = DMatrix::from_element(n, n - 1, Dd::ZERO);
    let (mut scale, mut means) = (Vec::new(), Vec::new());
    for (s, &j) in kept.iter().enumerate() {
        let shared = (0..n).fold(Dd::ZERO, |sum, k| sum + caller[(k, index)] * caller[(k, j)]);
        let mean = shared / own;
        for k in 0..n {
            matrix[(k, s)] = caller[(k, j)] - mean * caller[(k, index)];
        }
        // nothing but rounding is left of a column that does not vary: doubles differ by more
        if length_squared(&matrix, s) <= length_squared(caller, j) * 1e-36 {
            matrix.column_mut(s).fill(Dd::ZERO);
        }
        let deviation = positive((length_squared(&matrix, s) / weight).sqrt());
        let inverse = Dd::ONE / deviation;
        matrix.column_mut(s).iter_mut().for_each(|x| *x *= inverse);
        scale.push(deviation);
        means.push(mean);
    }
    let constant = Constant { index, means, length_squared: own.to_f64() };
    Ok(ScaledColumns { matrix, kept, scale, constant: Some(constant) })
}

impl Constant {
    /// Coefficient of the constant when all others are 0: the projection of the heights on the
    /// constant column.
    pub(crate) fn level(&self, caller: &DMatrix<Dd>, qty: &[Dd]) -> Dd {
        let own = length_squared(caller, self.index);
        let shared = qty.iter().enumerate().fold(Dd::ZERO, |sum, (k, &b)| sum + caller[(k, self.index)] * b);
        shared / own
    }
}
