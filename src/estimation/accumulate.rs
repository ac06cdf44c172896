//! Passes over the nodes: the normal equations of the working basis, and residuals with their projections.
//!
//! Nodes are taken in chunks of a fixed size whose partial sums are added in order, so that results do not
//! depend on how many threads work. In products of Chebyshev polynomials all n² sums of products follow from
//! the (2p+1)(2q+1) moments `Σ w Tₐ(u) T_b(v)`, because `2 TᵢTⱼ = T_{i+j} + T_{|i−j|}`.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::{
    design::{Axis, Basis, Design},
    sample::Sample,
};
use crate::{
    geometry::Mapping,
    numerics::{
        Dd, Real,
        wide::{Ddx4, F64x4, LANES, Lanes},
    },
};

/// Nodes of one partial sum.
const CHUNK: usize = 4096;
/// From how many nodes on chunks are shared among threads.
const PARALLEL: usize = 65_536;

/// `WᵀΩW`, `WᵀΩz` and `WᵀΩ1` of the working basis, Ω being the weights.
pub struct Normal {
    pub gram: DMatrix<f64>,
    pub rhs: Vec<f64>,
    pub ones: Vec<f64>,
}

/// What one pass over the residuals `z − Wc` yields.
pub struct ResidualPass {
    /// `WᵀΩr`.
    pub projected: Vec<Dd>,
    /// `Σ w r²`.
    pub rss: Dd,
    pub max_abs: f64,
    /// The residuals, when asked for.
    pub values: Vec<f64>,
}

/// How exactly a residual pass is to be computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Precision {
    Double,
    DoubleDouble,
}

/// From how many nodes on residuals, formed in double-double, are projected in double precision: what that rounding
/// leaves averages out below the rounding of the heights themselves.
const MANY: usize = 2_048;

/// Relative error that projecting residuals leaves in a double-double pass over `count` nodes.
pub fn projection_error(count: usize, residual: f64, size: f64) -> f64 {
    if count >= MANY && size > 0.0 { f64::EPSILON * residual / size / (count as f64).sqrt() } else { 0.0 }
}

/// Runs `work` over every chunk and folds the results in order.
fn over_chunks<P: Send>(count: usize, work: impl Fn(std::ops::Range<usize>) -> P + Sync, fold: impl FnMut(P)) {
    let chunks = count.div_ceil(CHUNK);
    let range = |i: usize| i * CHUNK..((i + 1) * CHUNK).min(count);
    if count < PARALLEL {
        (0..chunks).map(|i| work(range(i))).for_each(fold);
    } else {
        let parts: Vec<P> = (0..chunks).into_par_iter().map(|i| work(range(i))).collect();
        parts.into_iter().for_each(fold);
    }
}

/// The two mapped axes of a product of Chebyshev polynomials.
struct Chebyshev<'a> {
    u: (Mapping, usize),
    v: (Mapping, usize),
    terms: &'a [(usize, usize)],
}

fn chebyshev(design: &Design) -> Option<Chebyshev<'_>> {
    match &design.basis {
        Basis::Product {
            u: Axis::Polynomial { mapping: mu, size: p, .. },
            v: Axis::Polynomial { mapping: mv, size: q, .. },
        } => Some(Chebyshev { u: (*mu, *p), v: (*mv, *q), terms: &design.terms }),
        _ => None,
    }
}

#[inline(always)]
fn chebyshev_lanes<L: Lanes>(t: L, one: L, zero: L, out: &mut [L]) {
    let double = t.add(t);
    for i in 0..out.len() {
        out[i] = match i {
            0 => one,
            1 => t,
            _ => double.fma(out[i - 1], zero.sub(out[i - 2])),
        };
    }
}

/// The normal equations in double precision.
pub fn normal_equations(design: &Design, sample: &Sample) -> Normal {
    match chebyshev(design) {
        Some(axes) => from_moments(&axes, sample),
        None => from_rows(design, sample),
    }
}

/// Groups of four nodes whose products are summed before an accumulator is touched.
const GROUPS: usize = 8;

fn from_moments(axes: &Chebyshev, sample: &Sample) -> Normal {
    let (p, q) = (axes.u.1, axes.v.1);
    let (mp, mq) = (2 * p - 1, 2 * q - 1);
    let mut totals = vec![Dd::ZERO; mp * mq + p * q];
    over_chunks(
        sample.count(),
        |range| {
            let mut sums = vec![F64x4::ZERO; mp * mq + p * q];
            let one = F64x4([1.0; LANES]);
            let mut a = vec![[F64x4::ZERO; GROUPS]; mp];
            let mut b = vec![[F64x4::ZERO; GROUPS]; mq];
            let mut za = vec![[F64x4::ZERO; GROUPS]; p];
            let (mut row_u, mut row_v) = (vec![F64x4::ZERO; mp], vec![F64x4::ZERO; mq]);
            let mut start = range.start;
            while start < range.end {
                let groups = (range.end - start).div_ceil(LANES).min(GROUPS);
                for g in 0..groups {
                    let four = sample.four(start + g * LANES);
                    let z = F64x4(four.z);
                    chebyshev_lanes(
                        F64x4::mapped(four.u, axes.u.0.center, axes.u.0.scale),
                        one,
                        F64x4::ZERO,
                        &mut row_u,
                    );
                    chebyshev_lanes(
                        F64x4::mapped(four.v, axes.v.0.center, axes.v.0.scale),
                        one,
                        F64x4::ZERO,
                        &mut row_v,
                    );
                    for (to, from) in a.iter_mut().zip(&row_u) {
                        to[g] = from.mul_doubles(four.w);
                    }
                    for (to, from) in za.iter_mut().zip(&a) {
                        to[g] = from[g].mul(z);
                    }
                    for (to, from) in b.iter_mut().zip(&row_v) {
                        to[g] = *from;
                    }
                }
                let products = |a: &[F64x4; GROUPS], b: &[F64x4; GROUPS], mut sum: F64x4| {
                    for g in 0..groups {
                        sum = a[g].fma(b[g], sum);
                    }
                    sum
                };
                for i in 0..mp {
                    for j in 0..mq {
                        sums[i * mq + j] = products(&a[i], &b[j], sums[i * mq + j]);
                    }
                }
                for (i, za) in za.iter().enumerate() {
                    for (j, b) in b[..q].iter().enumerate() {
                        let at = mp * mq + i * q + j;
                        sums[at] = products(za, b, sums[at]);
                    }
                }
                start += groups * LANES;
            }
            sums
        },
        |sums| {
            for (total, sum) in totals.iter_mut().zip(sums) {
                *total += sum.sum();
            }
        },
    );
    let moment = |i: usize, j: usize| totals[i * mq + j].to_f64();
    let n = axes.terms.len();
    let mut gram = DMatrix::zeros(n, n);
    for (column, &(i, j)) in axes.terms.iter().enumerate() {
        for (row, &(k, l)) in axes.terms.iter().enumerate().take(column + 1) {
            let (iu, du, jv, dv) = (i + k, i.abs_diff(k), j + l, j.abs_diff(l));
            let value = 0.25 * ((moment(iu, jv) + moment(du, jv)) + (moment(iu, dv) + moment(du, dv)));
            gram[(row, column)] = value;
            gram[(column, row)] = value;
        }
    }
    let rhs = axes.terms.iter().map(|&(i, j)| totals[mp * mq + i * q + j].to_f64()).collect();
    let ones = axes.terms.iter().map(|&(i, j)| moment(i, j)).collect();
    Normal { gram, rhs, ones }
}

/// Any basis: row by row, touching only what is not 0.
fn from_rows(design: &Design, sample: &Sample) -> Normal {
    let n = design.size();
    let mut normal = Normal { gram: DMatrix::zeros(n, n), rhs: vec![0.0; n], ones: vec![0.0; n] };
    over_chunks(
        sample.count(),
        |range| {
            let mut part = Normal { gram: DMatrix::zeros(n, n), rhs: vec![0.0; n], ones: vec![0.0; n] };
            let mut row = Row::<f64>::new(design);
            for k in range {
                row.at(design, sample, k);
                let (w, z) = (sample.w(k), sample.z(k));
                for (s, &j) in row.index.iter().enumerate() {
                    let weighted = w * row.values[s];
                    part.rhs[j] += weighted * z;
                    part.ones[j] += weighted;
                    for (t, &i) in row.index.iter().enumerate().take(s + 1) {
                        part.gram[(i, j)] += weighted * row.values[t];
                    }
                }
            }
            part
        },
        |part| {
            normal.gram += part.gram;
            normal.rhs.iter_mut().zip(part.rhs).for_each(|(total, part)| *total += part);
            normal.ones.iter_mut().zip(part.ones).for_each(|(total, part)| *total += part);
        },
    );
    normal.gram.fill_lower_triangle_with_upper_triangle();
    normal
}

/// One row of the working matrix `W`: the columns that are not 0 and their values.
pub struct Row<T> {
    pub index: Vec<usize>,
    pub values: Vec<T>,
    u: Vec<T>,
    v: Vec<T>,
}

impl<T: Real> Row<T> {
    /// Room for the rows of `design`.
    pub fn new(design: &Design) -> Self {
        let zeros = |size: usize| vec![T::of(0.0); size];
        let (u, v) = match &design.basis {
            Basis::Product { u, v } => (zeros(u.size()), zeros(v.size())),
            Basis::Columns { .. } => (Vec::new(), Vec::new()),
        };
        Row { index: Vec::with_capacity(design.size()), values: Vec::with_capacity(design.size()), u, v }
    }

    /// Fills in the row of counted node `k`.
    pub fn at(&mut self, design: &Design, sample: &Sample, k: usize) {
        self.index.clear();
        self.values.clear();
        match &design.basis {
            Basis::Columns { scale } => {
                for (j, (x, s)) in sample.matrix_row(k).iter().zip(scale).enumerate() {
                    self.index.push(j);
                    self.values.push(T::of(x / s));
                }
            }
            Basis::Product { u, v } => {
                let (x, y) = sample.place(k);
                u.row(x, &mut self.u);
                v.row(y, &mut self.v);
                let zero = T::of(0.0);
                for (column, &(i, j)) in design.terms.iter().enumerate() {
                    if self.u[i] != zero && self.v[j] != zero {
                        self.index.push(column);
                        self.values.push(self.u[i] * self.v[j]);
                    }
                }
            }
        }
    }
}

/// Residuals of the working coefficients `c`, evaluated to `precision`; `values` asks for the residuals themselves.
pub fn residual_pass(design: &Design, sample: &Sample, c: &[Dd], precision: Precision, values: bool) -> ResidualPass {
    match (chebyshev(design), precision) {
        (Some(axes), Precision::Double) => lane_residuals::<F64x4, F64x4>(&axes, sample, c, values),
        (Some(axes), Precision::DoubleDouble) if sample.count() >= MANY => {
            lane_residuals::<Ddx4, F64x4>(&axes, sample, c, values)
        }
        (Some(axes), Precision::DoubleDouble) => lane_residuals::<Ddx4, Ddx4>(&axes, sample, c, values),
        (None, Precision::Double) => row_residuals::<f64>(design, sample, c, values),
        (None, Precision::DoubleDouble) => row_residuals::<Dd>(design, sample, c, values),
    }
}

struct Part<S> {
    projected: Vec<S>,
    rss: Dd,
    max_abs: f64,
    values: Vec<f64>,
}

/// `L`: the arithmetic in which residuals are formed; `S`: in which they are projected.
fn lane_residuals<L: Lanes, S: Lanes>(axes: &Chebyshev, sample: &Sample, c: &[Dd], keep: bool) -> ResidualPass {
    let (p, q) = (axes.u.1, axes.v.1);
    // coefficients as a table, column by column of v; absent terms (total degree) end a column early
    let mut table = vec![L::ZERO; p * q];
    let mut heights = vec![0; q];
    for (&(i, j), &value) in axes.terms.iter().zip(c) {
        table[j * p + i] = L::splat(value);
        heights[j] = heights[j].max(i + 1);
    }
    let n = c.len();
    let mut pass = ResidualPass {
        projected: vec![Dd::ZERO; n],
        rss: Dd::ZERO,
        max_abs: 0.0,
        values: Vec::with_capacity(if keep { sample.count() } else { 0 }),
    };
    over_chunks(
        sample.count(),
        |range| {
            let mut part = Part {
                projected: vec![S::ZERO; p * q],
                rss: Dd::ZERO,
                max_abs: 0.0,
                values: Vec::with_capacity(if keep { range.len() } else { 0 }),
            };
            let one = L::splat(Dd::ONE);
            let (mut a, mut b) = (vec![L::ZERO; p], vec![L::ZERO; q]);
            let mut narrow_a = vec![S::ZERO; p];
            let mut rss = L::ZERO;
            let mut start = range.start;
            while start < range.end {
                let four = sample.four(start);
                chebyshev_lanes(L::mapped(four.u, axes.u.0.center, axes.u.0.scale), one, L::ZERO, &mut a);
                chebyshev_lanes(L::mapped(four.v, axes.v.0.center, axes.v.0.scale), one, L::ZERO, &mut b);
                let mut fitted = L::ZERO;
                for j in 0..q {
                    let column = &table[j * p..j * p + heights[j]];
                    let mut sum = L::ZERO;
                    for (c, a) in column.iter().zip(&a) {
                        sum = sum.accumulate(*c, *a);
                    }
                    fitted = fitted.accumulate(sum.settled(), b[j]);
                }
                let residual = L::from_doubles(four.z).sub(fitted.settled());
                let weighted = residual.mul_doubles(four.w);
                rss = weighted.fma(residual, rss);
                let plain = residual.to_doubles();
                let here = (range.end - start).min(LANES);
                for r in &plain[..here] {
                    part.max_abs = part.max_abs.max(r.abs());
                }
                if keep {
                    part.values.extend_from_slice(&plain[..here]);
                }
                let narrow = |x: L| {
                    let (hi, lo) = x.parts();
                    S::from_parts(hi, lo)
                };
                for (to, from) in narrow_a.iter_mut().zip(&a) {
                    *to = narrow(*from);
                }
                let weighted = narrow(weighted);
                for j in 0..q {
                    let share = weighted.mul(narrow(b[j]));
                    for (sum, a) in part.projected[j * p..j * p + heights[j]].iter_mut().zip(&narrow_a) {
                        *sum = sum.accumulate(share, *a);
                    }
                }
                start += LANES;
            }
            part.rss = rss.sum();
            part
        },
        |part| {
            for (total, &(i, j)) in pass.projected.iter_mut().zip(axes.terms) {
                *total += part.projected[j * p + i].settled().sum();
            }
            pass.rss += part.rss;
            pass.max_abs = pass.max_abs.max(part.max_abs);
            pass.values.extend(part.values);
        },
    );
    pass
}

fn row_residuals<T: Real>(design: &Design, sample: &Sample, c: &[Dd], keep: bool) -> ResidualPass {
    let n = c.len();
    let c: Vec<T> = c.iter().map(|&c| T::of_dd(c)).collect();
    let mut pass = ResidualPass { projected: vec![Dd::ZERO; n], rss: Dd::ZERO, max_abs: 0.0, values: Vec::new() };
    over_chunks(
        sample.count(),
        |range| {
            let mut part = Part { projected: vec![T::of(0.0); n], rss: Dd::ZERO, max_abs: 0.0, values: Vec::new() };
            let mut row = Row::<T>::new(design);
            let mut rss = T::of(0.0);
            for k in range {
                row.at(design, sample, k);
                let mut residual = T::of(sample.z(k));
                for (&j, &x) in row.index.iter().zip(&row.values) {
                    residual -= x * c[j];
                }
                let weighted = residual.mul_f64(sample.w(k));
                rss += weighted * residual;
                for (&j, &x) in row.index.iter().zip(&row.values) {
                    part.projected[j] += x * weighted;
                }
                let plain = residual.to_f64();
                part.max_abs = part.max_abs.max(plain.abs());
                if keep {
                    part.values.push(plain);
                }
            }
            part.rss = rss.to_dd();
            part
        },
        |part| {
            for (total, part) in pass.projected.iter_mut().zip(part.projected) {
                *total += part.to_dd();
            }
            pass.rss += part.rss;
            pass.max_abs = pass.max_abs.max(part.max_abs);
            pass.values.extend(part.values);
        },
    );
    pass
}
