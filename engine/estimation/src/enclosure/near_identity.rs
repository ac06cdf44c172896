//! `M = SᵀWᵀΩWS`, which is close to the identity where S is close to R⁻¹.

use nalgebra::DMatrix;

use super::rounding::{Rounding, UNIT, running};
use crate::{
    data::Sample,
    design::{Design, Row, tile::Chebyshev},
    factor::{gram_of_moments, over_chunks},
};
use flankfit_numerics::{
    Dd,
    ball::enlarged,
    cancel::{self, Asking},
    lanes::{Ddx4, F64x4, LANES, Lanes},
    with_fma,
};

/// Error of M from moments below which rows are not needed: it is the relative error of leverages.
const SMALL: f64 = 1e-17;

/// M less the identity.
pub(super) struct NearIdentity {
    pub excess: DMatrix<f64>,
    /// Bound of the error of `excess` (2-norm).
    pub error: f64,
}

impl NearIdentity {
    /// η ≥ ‖M − I‖.
    pub(super) fn distance(&self) -> f64 {
        enlarged(enlarged(self.excess.norm()) + self.error)
    }

    /// Takes M as the upper triangle of `m`, whose error is `error`.
    pub(super) fn new(m: &DMatrix<Dd>, error: f64) -> Self {
        let n = m.ncols();
        let entry = |i: usize, j: usize| if i == j { (m[(i, i)] - 1.0).hi } else { m[(i.min(j), i.max(j))].hi };
        let excess = DMatrix::from_fn(n, n, entry);
        // rounding to double
        let error = enlarged(error + f64::EPSILON * excess.norm());
        NearIdentity { excess, error }
    }
}

/// M over the nodes of `sample`; `weight` is Σw, `spread` the length of the column sums of |S|.
pub(super) fn near_identity(
    design: &Design,
    sample: &Sample,
    s: &DMatrix<Dd>,
    (weight, spread): (f64, f64),
    rounding: &Rounding,
) -> NearIdentity {
    let n = s.ncols() as f64;
    let of_moments = 1.1 * (rounding.moments + 18.0 * n * UNIT) * weight * spread * spread;
    if let Some(axes) = Chebyshev::of(design).filter(|_| of_moments < SMALL) {
        return NearIdentity::new(&congruent(&gram_of_moments(&axes, sample), s), enlarged(of_moments));
    }
    // ‖√Ω(Q̂ − WS)‖, and from it the error of Q̂ᵀΩQ̂
    let stray = weight.sqrt() * spread * (UNIT * running(s.ncols()) * rounding.largest + rounding.entry);
    NearIdentity::new(&of_rows(design, sample, s), enlarged(2.2 * stray + stray * stray + 1.1 * n * rounding.sum))
}

/// `SᵀGS`, its upper triangle, from that of G.
fn congruent(gram: &DMatrix<Dd>, s: &DMatrix<Dd>) -> DMatrix<Dd> {
    let n = s.ncols();
    let mut out = DMatrix::from_element(n, n, Dd::ZERO);
    for j in (0..n).asking(10 * n * n) {
        let mut product = vec![Dd::ZERO; n];
        for k in 0..=j {
            let factor = s[(k, j)];
            product.iter_mut().zip(gram.column(k).iter()).for_each(|(sum, g)| *sum += *g * factor);
        }
        for i in 0..=j {
            out[(i, j)] = (0..=i).fold(Dd::ZERO, |sum, k| sum + s[(k, i)] * product[k]);
        }
    }
    out
}

/// `Σ w qqᵀ` with q = Sᵀx for every row x of W.
fn of_rows(design: &Design, sample: &Sample, s: &DMatrix<Dd>) -> DMatrix<Dd> {
    let n = s.ncols();
    let upper: Vec<(usize, usize)> = (0..n).flat_map(|j| (0..=j).map(move |i| (i, j))).collect();
    let lanes: Vec<Ddx4> = upper.iter().map(|&place| Ddx4::splat(s[place])).collect();
    let mut total = vec![Dd::ZERO; upper.len()];
    over_chunks(
        sample.count(),
        |range| {
            let mut sums = vec![Ddx4::ZERO; upper.len()];
            let (mut rows, mut q) = (vec![Ddx4::ZERO; n], vec![Ddx4::ZERO; n]);
            let mut row = Row::<Dd>::new(design);
            for start in range.clone().step_by(LANES) {
                cancel::every(10 * n * n, (start - range.start) / LANES);
                let mut weights = F64x4::ZERO;
                rows.fill(Ddx4::ZERO);
                for k in start..(start + LANES).min(range.end) {
                    row.at(design, sample, k);
                    for (&j, &x) in row.index.iter().zip(&row.values) {
                        rows[j].set(k - start, x);
                    }
                    weights.as_mut_array()[k - start] = sample.w(k);
                }
                add_rows(&lanes, &rows, weights, &mut q, &mut sums);
            }
            sums
        },
        |sums| total.iter_mut().zip(sums).for_each(|(total, sum)| *total += sum.settled().sum_of_pairs()),
    );
    let mut out = DMatrix::from_element(n, n, Dd::ZERO);
    upper.iter().zip(total).for_each(|(&place, sum)| out[place] = sum);
    out
}

with_fma! {
    /// Adds `w qqᵀ` of four rows to the upper triangle; q is scratch.
    fn add_rows(s: &[Ddx4], rows: &[Ddx4], weights: F64x4, q: &mut [Ddx4], sums: &mut [Ddx4]) {
        let (mut s, mut sums) = (s, sums);
        for j in 0..rows.len() {
            let (column, rest) = s.split_at(j + 1);
            s = rest;
            let mut sum = Ddx4::ZERO;
            for (s, x) in column.iter().zip(rows) {
                sum = sum.accumulate(*s, *x);
            }
            q[j] = sum.settled();
            let weighted = q[j].mul_doubles(weights);
            let (column, rest) = std::mem::take(&mut sums).split_at_mut(j + 1);
            sums = rest;
            for (sum, q) in column.iter_mut().zip(q.iter()) {
                *sum = sum.accumulate(*q, weighted);
            }
        }
    }
}
