//! A full grid without weights: `W = W_u ⊗ W_v`, so QR, spectrum and solution are those of two
//! small matrices.
//!
//! The heights are contracted once, `B = Q_uᵀ Z Q_v`, with products and sums carried in
//! double-double; one more pass forms the residuals. Everything after that is small.

use std::{ops::Range, sync::Arc};

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::residual_pass::Precision;
use crate::{
    checks::OfGrid,
    data::Grid,
    design::{Axis, Basis, Design},
};
use flankfit_numerics::{
    Dd, Real,
    cancel::{self, Asking},
    lanes::{Ddx4, F64x4, LANES, Lanes},
    qr, triangular, with_fma,
};

/// Grid rows of one partial sum, and from how many nodes on rows are shared among threads.
const ROWS: usize = 32;
const PARALLEL: usize = 65_536;
/// A residual this small against the heights has lost digits in double precision and is formed
/// anew.
const SMALL: f64 = 1e-7;
/// Nodes up to which residuals are formed in double-double at once.
const FEW: usize = 256;

/// The two axes of a full grid, before a height is seen.
pub(crate) struct Axes {
    pub u: AxisFactor,
    pub v: AxisFactor,
    /// Parts of the residual checks, made once.
    pub checks: OfGrid,
}

/// The factors of a full grid.
pub(crate) struct Separable {
    pub axes: Arc<Axes>,
    /// `Q_uᵀ Z Q_v`, row by row: b in the order of the terms.
    pub qty: Vec<Dd>,
    pub rss: f64,
    pub max_abs: f64,
    /// `Σ |r|`.
    pub sum_abs: f64,
    /// Residuals, row by row.
    pub residuals: Vec<f64>,
    pub relative_error: f64,
}

/// QR of one axis.
pub(crate) struct AxisFactor {
    pub r: DMatrix<Dd>,
    /// T of this axis.
    pub change: DMatrix<Dd>,
    /// nodes × functions.
    q: DMatrix<Dd>,
    /// Leverage of each position in a fit of this axis alone.
    pub leverages: Vec<f64>,
}

impl AxisFactor {
    /// `None` where the axis does not determine its functions (too few positions, empty spans).
    fn new(axis: &Axis, positions: &[f64]) -> Option<Self> {
        let (m, n) = (positions.len(), axis.size());
        if m < n {
            return None;
        }
        let mut w = DMatrix::from_element(m, n, Dd::ZERO);
        let mut row = vec![Dd::ZERO; n];
        for (i, &x) in positions.iter().enumerate().asking(50 * n) {
            axis.row(x, &mut row);
            for (j, value) in row.iter().enumerate() {
                w[(i, j)] = *value;
            }
        }
        let r = qr::qr_with_rhs(w.clone(), DVector::from_element(m, Dd::ZERO)).r;
        let length = |j: usize| w.column(j).iter().map(|x| x.to_f64().powi(2)).sum::<f64>().sqrt();
        if !(0..n).all(|j| r[(j, j)].to_f64() > 1e-8 * length(j)) {
            return None;
        }
        let inverse = triangular::inverse_upper(&r);
        let mut q = DMatrix::from_element(m, n, Dd::ZERO);
        for j in 0..n {
            for k in 0..=j {
                let factor = inverse[(k, j)];
                for i in (0..m).asking(10) {
                    let sum = w[(i, k)].fma(factor, q[(i, j)]);
                    q[(i, j)] = sum;
                }
            }
        }
        let leverages = q.row_iter().map(|row| row.iter().map(|x| x.hi * x.hi).sum()).collect();
        Some(AxisFactor { r, change: axis.change(), q, leverages })
    }

    /// The orthonormal factor `W R⁻¹`, nodes × functions.
    pub(crate) fn q(&self) -> &DMatrix<Dd> {
        &self.q
    }

    /// Positions and functions.
    pub(crate) fn shape(&self) -> (usize, usize) {
        self.q.shape()
    }

    /// Returns the greatest leverage of a position in a fit of this axis alone.
    pub(crate) fn greatest_leverage(&self) -> f64 {
        self.leverages.iter().copied().fold(0.0, f64::max)
    }

    /// Returns the row of the orthonormal factor at a position.
    pub(crate) fn row(&self, position: usize) -> Vec<f64> {
        self.q.row(position).iter().map(|x| x.to_f64()).collect()
    }

    /// Rows of the orthonormal factor, a column of this for each position.
    pub(crate) fn orthonormal(&self) -> DMatrix<f64> {
        self.q.map(|x| x.to_f64()).transpose()
    }
}

impl Axes {
    /// Factors the axes of a grid; `None` where one of them leaves its functions undetermined.
    pub(crate) fn new(design: &Design, grid: &Grid) -> Option<Self> {
        let Basis::Product { u, v } = &design.basis else { return None };
        let (u, v) = (AxisFactor::new(u, &grid.u)?, AxisFactor::new(v, &grid.v)?);
        Some(Axes { u, v, checks: OfGrid::default() })
    }

    /// `R = R_u ⊗ R_v`.
    pub(crate) fn r(&self) -> DMatrix<Dd> {
        kronecker(&self.u.r, &self.v.r)
    }
}

impl Separable {
    /// Projects the heights of a full, unweighted grid.
    pub(crate) fn new(axes: Arc<Axes>, grid: &Grid) -> Self {
        let qty = contract(&axes.u.q, &axes.v.q, &grid.z);
        let mut separable =
            Separable { axes, qty, rss: 0.0, max_abs: 0.0, sum_abs: 0.0, residuals: Vec::new(), relative_error: 1e-28 };
        let fitted: f64 = separable.qty.iter().map(|b| b.to_f64() * b.to_f64()).sum();
        let pass = |precision| separable.pass(grid, &separable.qty, precision, true);
        let large = (grid.z.len() > FEW).then(|| pass(Precision::Double));
        let found = large
            .filter(|found| found.rss.to_f64() > SMALL * SMALL * fitted)
            .unwrap_or_else(|| pass(Precision::DoubleDouble));
        (separable.rss, separable.max_abs, separable.sum_abs) = (found.rss.to_f64(), found.max_abs, found.sum_abs);
        separable.residuals = found.values;
        separable
    }

    /// `Σ r²`, `max |r|` and, if requested, the residuals `Z − Q_u B Q_vᵀ` of `b` (row by row).
    pub(crate) fn residuals(&self, grid: &Grid, b: &[Dd], precision: Precision, keep: bool) -> (f64, f64, Vec<f64>) {
        let pass = self.pass(grid, b, precision, keep);
        (pass.rss.to_f64(), pass.max_abs, pass.values)
    }

    fn pass(&self, grid: &Grid, b: &[Dd], precision: Precision, keep: bool) -> Pass {
        match precision {
            Precision::Double => residuals::<F64x4>(&self.axes.u.q, &self.axes.v.q, b, grid, keep),
            Precision::DoubleDouble => residuals::<Ddx4>(&self.axes.u.q, &self.axes.v.q, b, grid, keep),
        }
    }
}

/// Residuals of some rows of a grid, or of all.
struct Pass {
    rss: Dd,
    max_abs: f64,
    sum_abs: f64,
    values: Vec<f64>,
}

/// The Kronecker product of two upper triangular matrices.
pub(crate) fn kronecker<T: Real>(a: &DMatrix<T>, b: &DMatrix<T>) -> DMatrix<T> {
    let (p, q) = (a.ncols(), b.ncols());
    let mut out = DMatrix::from_element(a.nrows() * b.nrows(), p * q, T::of(0.0));
    for i in 0..p {
        for j in 0..q {
            for k in 0..a.nrows() {
                if a[(k, i)] == T::of(0.0) {
                    continue;
                }
                for l in 0..b.nrows() {
                    out[(k * b.nrows() + l, i * q + j)] = a[(k, i)] * b[(l, j)];
                }
            }
        }
    }
    out
}

/// Columns of Q_v as lanes along v, padded with 0.
fn lanes_of<L: Lanes>(q: &DMatrix<Dd>) -> Vec<Vec<L>> {
    let m = q.nrows();
    (0..q.ncols())
        .map(|j| {
            (0..m.div_ceil(LANES))
                .map(|g| {
                    let at = |i: usize| if g * LANES + i < m { q[(g * LANES + i, j)] } else { Dd::ZERO };
                    let (hi, lo) = (std::array::from_fn(|i| at(i).hi), std::array::from_fn(|i| at(i).lo));
                    L::from_parts(F64x4::new(hi), F64x4::new(lo))
                })
                .collect()
        })
        .collect()
}

#[inline(always)]
fn four(row: &[f64], start: usize) -> F64x4 {
    if start + LANES <= row.len() {
        F64x4::new(std::array::from_fn(|i| row[start + i]))
    } else {
        F64x4::new(std::array::from_fn(|i| row.get(start + i).copied().unwrap_or(0.0)))
    }
}

/// Applies `work` to groups of grid rows, in order.
fn over_rows<P: Send>(rows: usize, nodes: usize, work: impl Fn(Range<usize>) -> P + Sync) -> Vec<P> {
    let groups = rows.div_ceil(ROWS);
    let handle = cancel::current();
    let range = |g: usize| g * ROWS..((g + 1) * ROWS).min(rows);
    if nodes < PARALLEL {
        (0..groups).map(|g| work(range(g))).collect()
    } else {
        (0..groups).into_par_iter().map(|g| cancel::carry(handle.as_ref(), || work(range(g)))).collect()
    }
}

/// `Q_uᵀ Z Q_v`.
fn contract(qu: &DMatrix<Dd>, qv: &DMatrix<Dd>, z: &[f64]) -> Vec<Dd> {
    let columns: Vec<Vec<Ddx4>> = lanes_of(qv);
    let parts = over_rows(qu.nrows(), z.len(), |rows| contract_rows(qu, &columns, z, rows));
    let mut total = vec![Dd::ZERO; qu.ncols() * qv.ncols()];
    for part in parts {
        total.iter_mut().zip(part).for_each(|(total, part)| *total += part);
    }
    total
}

fn residuals<L: Lanes>(qu: &DMatrix<Dd>, qv: &DMatrix<Dd>, b: &[Dd], grid: &Grid, keep: bool) -> Pass {
    let columns: Vec<Vec<L>> = lanes_of(qv);
    let z = &grid.z;
    let parts = over_rows(qu.nrows(), z.len(), |rows| residual_rows(qu, &columns, b, z, rows, keep));
    let mut parts = parts.into_iter();
    let Some(mut whole) = parts.next() else { unreachable!("a grid has rows") };
    for part in parts {
        whole.rss += part.rss;
        whole.max_abs = whole.max_abs.max(part.max_abs);
        whole.sum_abs += part.sum_abs;
        whole.values.extend(part.values);
    }
    whole
}

with_fma! {
    /// Contribution of some rows of the grid to `Q_uᵀ Z Q_v`.
    fn contract_rows(qu: &DMatrix<Dd>, columns: &[Vec<Ddx4>], z: &[f64], rows: Range<usize>) -> Vec<Dd> {
        let (p, q, nv) = (qu.ncols(), columns.len(), z.len() / qu.nrows());
        let mut sum = vec![Dd::ZERO; p * q];
        for k in rows.asking(4 * (p + nv) * q) {
            let row = &z[k * nv..(k + 1) * nv];
            for (j, column) in columns.iter().enumerate() {
                let mut dot = Ddx4::ZERO;
                for (g, lane) in column.iter().enumerate() {
                    dot = dot.add_product(*lane, four(row, g * LANES));
                }
                let dot = dot.settled().sum_of_pairs();
                for i in 0..p {
                    sum[i * q + j] = qu[(k, i)].fma(dot, sum[i * q + j]);
                }
            }
        }
        sum
    }

    /// Residuals of some rows of the grid.
    fn residual_rows<L: Lanes>(
        qu: &DMatrix<Dd>,
        columns: &[Vec<L>],
        b: &[Dd],
        z: &[f64],
        rows: Range<usize>,
        keep: bool,
    ) -> Pass {
        let (p, q, nv) = (qu.ncols(), columns.len(), z.len() / qu.nrows());
        let (mut rss, mut max_abs, mut sum_abs) = (L::ZERO, F64x4::ZERO, F64x4::ZERO);
        let mut values = Vec::with_capacity(if keep { rows.len() * nv } else { 0 });
        let mut weights: Vec<L> = Vec::with_capacity(q);
        for k in rows.asking(4 * (p + nv) * q) {
            weights.clear();
            weights.extend((0..q).map(|j| {
                let mut sum = Dd::ZERO;
                for i in 0..p {
                    sum = qu[(k, i)].fma(b[i * q + j], sum);
                }
                L::splat(L::Number::of_dd(sum))
            }));
            let row = &z[k * nv..(k + 1) * nv];
            for g in 0..nv.div_ceil(LANES) {
                let mut fitted = L::ZERO;
                for (column, weight) in columns.iter().zip(&weights) {
                    fitted = fitted.accumulate(column[g], *weight);
                }
                // padding: heights and functions are 0 there, so is the residual
                let residual = L::from_doubles(four(row, g * LANES)).sub(fitted.settled());
                rss = residual.fma(residual, rss);
                let plain = residual.to_doubles();
                max_abs = plain.abs().larger(max_abs);
                sum_abs = sum_abs + plain.abs();
                if keep {
                    values.extend_from_slice(&plain.to_array()[..(nv - g * LANES).min(LANES)]);
                }
            }
        }
        let sum_abs = sum_abs.to_array().into_iter().sum();
        let max_abs = max_abs.to_array().into_iter().fold(0.0, f64::max);
        Pass { rss: rss.sum_of_pairs().to_dd(), max_abs, sum_abs, values }
    }
}
