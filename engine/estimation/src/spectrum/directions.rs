//! Eigenvalues and eigenvectors of the scaled Fisher information matrix `F = X̃ᵀX̃`, never by
//! forming it.
//!
//! `X̃ = Q R̃`, so the singular values of the small matrix `R̃` are those of `X̃` and `λᵢ = σᵢ²`
//! (Eq. 23 of the paper needs the small ones, which forming XᵀX in double precision destroys once
//! cond(X) exceeds 1e8). One-sided Jacobi keeps their relative accuracy; where double precision
//! cannot promise it, the rotations are repeated in double-double.

use std::{ops::Deref, sync::Arc};

use nalgebra::DMatrix;

use super::columns::ScaledColumns;
use crate::{
    error::{FitError, Unconverged},
    factor::{Axes, AxisFactor, Factor, Separable},
    spec::Scaling,
};
use flankfit_numerics::{Dd, Real, cancel::Asking, jacobi, svd_dd, triangular};

/// Relative error of an eigenvalue that double precision may leave before double-double takes over.
const TOLERANCE: f64 = 1e-12;
const NOT_CONVERGED: FitError = FitError::NotConverged(Unconverged::SingularValues);

/// The eigen analysis of the scaled columns, before a height is seen; directions in ascending order
/// of eigenvalue.
#[derive(Clone)]
pub(crate) struct Directions {
    /// Eigenvalues λᵢ; 0 where the arithmetic cannot distinguish them from 0.
    pub lambda: Vec<f64>,
    /// Column i is Vᵢ, in the scaled columns.
    pub v: DMatrix<f64>,
    /// Column i is X̃Vᵢ in Q's coordinates.
    pub image: DMatrix<f64>,
    /// Number of λᵢ that are numerically nonzero.
    pub rank: usize,
    exact: Arc<Exact>,
}

/// The same in double-double, whole or by the axes of a grid.
enum Exact {
    Whole(Decomposition),
    /// And which direction of each axis makes a direction of the product, with `λᵢ`.
    Product {
        u: Decomposition,
        v: Decomposition,
        order: Vec<(usize, usize, Dd)>,
    },
}

/// The directions with what the heights have along them.
pub(crate) struct Spectrum {
    pub directions: Directions,
    /// aᵢ = Vᵢᵀ Â; 0 where λᵢ is.
    pub a: Vec<f64>,
    /// `V a` in double-double: the (minimum-norm) least-squares coefficients of the scaled columns.
    pub scaled: Vec<Dd>,
    /// Coefficient of the unpenalised constant when all others are 0; 0 where there is none.
    pub level: Dd,
}

impl Deref for Spectrum {
    type Target = Directions;

    fn deref(&self) -> &Directions {
        &self.directions
    }
}

/// Singular values ascending, right singular vectors and `R̃ V`, with the level below which the
/// arithmetic cannot distinguish them from 0.
struct Decomposition {
    sigma: Vec<Dd>,
    v: DMatrix<Dd>,
    image: DMatrix<Dd>,
    /// Singular values up to here are indistinguishable from 0.
    floor: f64,
}

fn widen(matrix: &DMatrix<f64>) -> DMatrix<Dd> {
    matrix.map(Dd::from)
}

fn decompose(matrix: &DMatrix<Dd>, floor: f64) -> Result<Decomposition, FitError> {
    let n = matrix.ncols();
    let plain = jacobi::svd(matrix.map(|x| x.to_f64())).ok_or(NOT_CONVERGED)?;
    let (low, high) = (plain.sigma[0], plain.sigma[n - 1]);
    if low > 0.0 && high / low * f64::EPSILON * n as f64 <= TOLERANCE {
        let sigma = plain.sigma.iter().map(|&s| Dd::from(s)).collect();
        return Ok(Decomposition { sigma, v: widen(&plain.v), image: widen(&plain.us), floor });
    }
    let exact = svd_dd(matrix).ok_or(NOT_CONVERGED)?;
    Ok(Decomposition { sigma: exact.sigma, v: exact.v, image: exact.us, floor })
}

/// Bound on the effect of rounding in double-double on a singular value of `R T P`.
fn rounding_floor(r: &DMatrix<Dd>, change: &DMatrix<Dd>, scale: impl Fn(usize) -> f64) -> f64 {
    let n = r.ncols();
    let mut sum = 0.0;
    for j in (0..n).asking(4 * n * n) {
        let mut column = 0.0;
        for i in 0..n {
            let spread: f64 = (i..=j.max(i)).map(|k| (r[(i, k)] * change[(k, j)]).to_f64().abs()).sum();
            column += spread * spread;
        }
        let s = scale(j);
        sum += column / (s * s);
    }
    2.0 * (n as f64) * Dd::EPSILON * 16.0 * sum.sqrt()
}

impl Directions {
    /// Analyses the scaled columns. Rank does not depend on how columns are scaled, but is
    /// determined best on columns of unit length: if it is known from there, it is given as `rank`.
    pub(crate) fn new(
        factor: &Factor,
        columns: &ScaledColumns,
        scaling: Scaling,
        rank: Option<usize>,
    ) -> Result<Self, FitError> {
        match (&factor.separable, scaling) {
            (Some(Separable { axes, .. }), Scaling::UnitLength | Scaling::None) => {
                Self::of_product(axes, scaling, rank)
            }
            _ => Self::of_matrix(factor, columns, rank),
        }
    }

    fn of_matrix(factor: &Factor, columns: &ScaledColumns, rank: Option<usize>) -> Result<Self, FitError> {
        // a column that is 0 has no error either
        let counts = |s: &usize| columns.matrix.column(*s).iter().any(|x| *x != Dd::ZERO);
        let floor = factor.rounded
            * rounding_floor(&factor.r, &factor.change, |j| {
                let at = columns.kept.iter().position(|&k| k == j).filter(counts);
                at.map_or(f64::INFINITY, |s| columns.scale[s].to_f64())
            });
        let parts = decompose(&columns.matrix, floor)?;
        let n = parts.sigma.len();
        let nonzero = |i: usize| match rank {
            Some(rank) => i >= n - rank && parts.sigma[i] > Dd::ZERO,
            None => parts.sigma[i].to_f64() > parts.floor,
        };
        let square = |i: usize| (parts.sigma[i] * parts.sigma[i]).to_f64();
        let lambda = (0..n).map(|i| if nonzero(i) { square(i) } else { 0.0 }).collect();
        let (v, image) = (parts.v.map(|x| x.to_f64()), parts.image.map(|x| x.to_f64()));
        Ok(Self::found(lambda, v, image, Exact::Whole(parts)))
    }

    /// The directions of `X_u ⊗ X_v` from those of its factors.
    fn of_product(axes: &Axes, scaling: Scaling, rank: Option<usize>) -> Result<Self, FitError> {
        let axis = |axis: &AxisFactor| {
            let mut matrix = triangular::multiply_upper(&axis.r, &axis.change);
            let mut scale = vec![1.0; matrix.ncols()];
            if scaling == Scaling::UnitLength {
                for (mut column, s) in matrix.column_iter_mut().zip(&mut scale) {
                    let length = column.iter().fold(Dd::ZERO, |sum, &x| sum + x * x).sqrt();
                    if length > Dd::ZERO {
                        let inverse = Dd::ONE / length;
                        column.iter_mut().for_each(|x| *x *= inverse);
                        *s = length.to_f64();
                    }
                }
            }
            decompose(&matrix, rounding_floor(&axis.r, &axis.change, |j| scale[j]))
        };
        let (u, v) = (axis(&axes.u)?, axis(&axes.v)?);
        let (p, q) = (u.sigma.len(), v.sigma.len());
        let n = p * q;
        // directions in ascending order of eigenvalue; equal ones keep the order of the axes
        let mut found: Vec<(usize, usize, f64, Dd)> = (0..p)
            .flat_map(|i| (0..q).map(move |j| (i, j)))
            .map(|(i, j)| {
                let nonzero = rank.is_some() || (u.sigma[i].to_f64() > u.floor && v.sigma[j].to_f64() > v.floor);
                let squared = (u.sigma[i] * u.sigma[i]) * (v.sigma[j] * v.sigma[j]);
                (i, j, if nonzero { squared.to_f64() } else { 0.0 }, squared)
            })
            .collect();
        found.sort_by(|x, y| x.2.total_cmp(&y.2));
        if let Some(rank) = rank {
            found[..n - rank].iter_mut().for_each(|entry| entry.2 = 0.0);
        }
        let combine = |a: &DMatrix<Dd>, b: &DMatrix<Dd>| {
            let (a, b) = (a.map(|x| x.to_f64()), b.map(|x| x.to_f64()));
            let mut out = DMatrix::zeros(n, n);
            for (column, &(i, j, _, _)) in found.iter().enumerate() {
                let mut to = out.column_mut(column);
                let mut row = 0;
                for k in 0..p {
                    for l in 0..q {
                        to[row] = a[(k, i)] * b[(l, j)];
                        row += 1;
                    }
                }
            }
            out
        };
        let (vectors, image) = (combine(&u.v, &v.v), combine(&u.image, &v.image));
        let lambda = found.iter().map(|entry| entry.2).collect();
        let order = found.into_iter().map(|(i, j, _, squared)| (i, j, squared)).collect();
        Ok(Self::found(lambda, vectors, image, Exact::Product { u, v, order }))
    }

    fn found(lambda: Vec<f64>, v: DMatrix<f64>, image: DMatrix<f64>, exact: Exact) -> Self {
        let rank = lambda.iter().filter(|l| **l > 0.0).count();
        Directions { lambda, v, image, rank, exact: Arc::new(exact) }
    }

    /// λₙ.
    pub(crate) fn largest(&self) -> f64 {
        self.lambda.last().copied().unwrap_or(0.0)
    }

    /// True if every eigenvalue is numerically nonzero.
    pub(crate) fn full_rank(&self) -> bool {
        self.rank == self.lambda.len()
    }
}

impl Spectrum {
    /// Coordinates of the heights, seen as `b = Qᵀ√Ωz`, along `directions`.
    pub(crate) fn new(directions: Directions, qty: &[Dd], level: Dd) -> Self {
        let (a, scaled) = match &*directions.exact {
            Exact::Whole(parts) => along_whole(parts, &directions.lambda, qty),
            Exact::Product { u, v, order } => along_product(u, v, order, &directions.lambda, qty),
        };
        Spectrum { directions, a, scaled, level }
    }
}

fn along_whole(parts: &Decomposition, lambda: &[f64], qty: &[Dd]) -> (Vec<f64>, Vec<Dd>) {
    let n = lambda.len();
    let mut a = vec![Dd::ZERO; n];
    for i in (0..n).filter(|&i| lambda[i] > 0.0) {
        let shown = parts.image.column(i).iter().zip(qty).fold(Dd::ZERO, |sum, (&x, &b)| sum + x * b);
        a[i] = shown / (parts.sigma[i] * parts.sigma[i]);
    }
    let scaled = (0..n).map(|j| (0..n).fold(Dd::ZERO, |sum, i| parts.v[(j, i)].fma(a[i], sum))).collect();
    (a.iter().map(|x| x.to_f64()).collect(), scaled)
}

fn along_product(
    u: &Decomposition,
    v: &Decomposition,
    order: &[(usize, usize, Dd)],
    lambda: &[f64],
    qty: &[Dd],
) -> (Vec<f64>, Vec<Dd>) {
    let (p, q) = (u.sigma.len(), v.sigma.len());
    // a = (Σ_u U_u)ᵀ B (U_v Σ_v) / λ
    let mut half = DMatrix::from_element(p, q, Dd::ZERO);
    for i in 0..p {
        for l in 0..q {
            half[(i, l)] = (0..p).fold(Dd::ZERO, |sum, k| u.image[(k, i)].fma(qty[k * q + l], sum));
        }
    }
    let mut a = DMatrix::from_element(p, q, Dd::ZERO);
    for (&(i, j, squared), &lambda) in order.iter().zip(lambda) {
        if lambda > 0.0 {
            a[(i, j)] = (0..q).fold(Dd::ZERO, |sum, l| half[(i, l)].fma(v.image[(l, j)], sum)) / squared;
        }
    }
    // V_u a V_vᵀ
    let mut left = DMatrix::from_element(p, q, Dd::ZERO);
    for k in 0..p {
        for j in 0..q {
            left[(k, j)] = (0..p).fold(Dd::ZERO, |sum, i| u.v[(k, i)].fma(a[(i, j)], sum));
        }
    }
    let mut scaled = Vec::with_capacity(p * q);
    for k in 0..p {
        for l in 0..q {
            scaled.push((0..q).fold(Dd::ZERO, |sum, j| v.v[(l, j)].fma(left[(k, j)], sum)));
        }
    }
    (order.iter().map(|&(i, j, _)| a[(i, j)].to_f64()).collect(), scaled)
}
