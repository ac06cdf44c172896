//! The normal equations of the working basis, `WᵀΩW c = WᵀΩz`.
//!
//! In products of Chebyshev polynomials all n² sums of products follow from the (2p+1)(2q+1)
//! moments `Σ w Tₐ(u) T_b(v)`, because `2 TᵢTⱼ = T_{i+j} + T_{|i−j|}`.

use std::ops::Range;

use nalgebra::DMatrix;

use super::chunks::over_chunks;
use crate::{
    data::Sample,
    design::{
        Design, Row,
        tile::{self, Chebyshev, GROUPS, TILE},
    },
};
use flankfit_numerics::{
    Dd, Real,
    cancel::Asking,
    lanes::{Ddx4, F64x4, Lanes},
    with_fma,
};

/// `WᵀΩW`, `WᵀΩz` and `WᵀΩ1` of the working basis, Ω being the weights.
pub(super) struct Normal<T> {
    pub gram: DMatrix<T>,
    pub rhs: Vec<T>,
    pub ones: Vec<T>,
}

/// The normal equations in double precision.
pub(super) fn normal_equations(design: &Design, sample: &Sample) -> Normal<f64> {
    match Chebyshev::of(design).filter(|_| !sample.is_white()) {
        Some(axes) => from_moments::<F64x4>(&axes, sample),
        None => from_rows(design, sample),
    }
}

/// `WᵀΩW` in double-double.
pub(crate) fn gram_of_moments(axes: &Chebyshev, sample: &Sample) -> DMatrix<Dd> {
    from_moments::<Ddx4>(axes, sample).gram
}

fn from_moments<L: Lanes>(axes: &Chebyshev, sample: &Sample) -> Normal<L::Number> {
    let (p, q) = axes.shape();
    let (mp, mq) = (2 * p - 1, 2 * q - 1);
    let mut totals = vec![Dd::ZERO; mp * mq + p * q];
    over_chunks(
        sample.count(),
        |range| moments::<L>(axes, sample, range),
        |sums| {
            for (total, sum) in totals.iter_mut().zip(sums) {
                *total += sum.settled().sum_of_pairs().to_dd();
            }
        },
    );
    let moment = |i: usize, j: usize| L::Number::of_dd(totals[i * mq + j]);
    let n = axes.terms.len();
    let mut gram = DMatrix::zeros(n, n);
    for (column, &(i, j)) in axes.terms.iter().enumerate() {
        for (row, &(k, l)) in axes.terms.iter().enumerate().take(column + 1) {
            let (iu, du, jv, dv) = (i + k, i.abs_diff(k), j + l, j.abs_diff(l));
            let value = (moment(iu, jv) + moment(du, jv)) + (moment(iu, dv) + moment(du, dv));
            let value = value.mul_f64(0.25);
            gram[(row, column)] = value;
            gram[(column, row)] = value;
        }
    }
    let rhs = axes.terms.iter().map(|&(i, j)| L::Number::of_dd(totals[mp * mq + i * q + j])).collect();
    let ones = axes.terms.iter().map(|&(i, j)| moment(i, j)).collect();
    Normal { gram, rhs, ones }
}

with_fma! {
    /// Moments and shares of the heights of one chunk of nodes.
    fn moments<L: Lanes>(axes: &Chebyshev, sample: &Sample, range: Range<usize>) -> Vec<L> {
        let (p, q) = axes.shape();
        let (mp, mq) = (2 * p - 1, 2 * q - 1);
        let mut sums = vec![L::ZERO; mp * mq + p * q];
        let (mut a, mut b) = (vec![[L::ZERO; GROUPS]; mp], vec![[L::ZERO; GROUPS]; mq]);
        let mut za = vec![[L::ZERO; GROUPS]; p];
        for start in range.step_by(TILE).asking(4 * TILE * (mp * mq + p * q)) {
            let nodes = sample.tile(start);
            tile::chebyshev(&nodes.u, axes.u.0, &mut a);
            tile::chebyshev(&nodes.v, axes.v.0, &mut b);
            if sample.weighted() || nodes.counted < TILE {
                for a in &mut a {
                    for g in 0..GROUPS {
                        a[g] = a[g].mul_doubles(nodes.w[g]);
                    }
                }
            }
            for (to, a) in za.iter_mut().zip(&a) {
                for g in 0..GROUPS {
                    to[g] = a[g].mul_doubles(nodes.z[g]);
                }
            }
            let (moments, shares) = sums.split_at_mut(mp * mq);
            for (row, a) in moments.chunks_exact_mut(mq).zip(&a) {
                row.iter_mut().zip(&b).for_each(|(sum, b)| *sum = tile::products(a, b, *sum));
            }
            for (row, a) in shares.chunks_exact_mut(q).zip(&za) {
                row.iter_mut().zip(&b).for_each(|(sum, b)| *sum = tile::products(a, b, *sum));
            }
        }
        sums
    }
}

/// Any basis: row by row, touching only what is not 0.
fn from_rows(design: &Design, sample: &Sample) -> Normal<f64> {
    let n = design.size();
    let mut normal = Normal { gram: DMatrix::zeros(n, n), rhs: vec![0.0; n], ones: vec![0.0; n] };
    over_chunks(
        sample.count(),
        |range| {
            let mut part = Normal { gram: DMatrix::zeros(n, n), rhs: vec![0.0; n], ones: vec![0.0; n] };
            let mut row = Row::<f64>::new(design);
            for k in range.asking(n * n) {
                row.at(design, sample, k);
                let (w, z, one) = (sample.w(k), sample.z(k), sample.one(k));
                for (s, &j) in row.index.iter().enumerate() {
                    let weighted = w * row.values[s];
                    part.rhs[j] += weighted * z;
                    part.ones[j] += weighted * one;
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
