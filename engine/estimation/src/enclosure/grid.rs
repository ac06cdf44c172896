//! Full grids without weights, where all matrices are products of two small ones.
//!
//! `Q̂ = WS + E` on each axis, b̂ = (Q̂u ⊗ Q̂v)ᵀz, and `c = (P_u ⊗ P_v)(b̂ + …)` with P = T⁻¹S.

use nalgebra::DMatrix;

use super::{
    Proved, change, dot, length,
    near_identity::NearIdentity,
    rounding::{UNIT, in_range, on_unit, polynomials, running},
};
use crate::{
    data::{Grid, Heights},
    design::{Axis, Basis, Design},
    factor::{AxisFactor, Precision, Separable},
};
use flankfit_numerics::{Ball, Dd, ball::enlarged, lanes::LANES, triangular};

/// Results of one axis.
struct OfAxis {
    /// P, of row j the entries from j on.
    rows: Vec<Vec<Ball>>,
    /// `(P M⁻¹ Pᵀ)ⱼⱼ`.
    leverages: Vec<Ball>,
    /// ‖M − I‖ at most.
    eta: f64,
    /// ‖Q̂ − WS‖ at most.
    stray: f64,
}

/// `None` where numbers are out of range.
pub(super) fn proved(design: &Design, separable: &Separable, grid: &Grid, heights: &Heights) -> Option<Proved> {
    let Basis::Product { u, v } = &design.basis else { return None };
    let (p, q) = (u.size(), v.size());
    let axes = [OfAxis::new(u, &separable.axes.u, &grid.u)?, OfAxis::new(v, &separable.axes.v, &grid.v)?];
    let [of_u, of_v] = &axes;
    let eta = enlarged(of_u.eta + of_v.eta + of_u.eta * of_v.eta);
    if !(eta < 0.1) || !in_range(heights.largest_plain) {
        return None;
    }
    let b = &separable.qty;
    let (z, moved) = (enlarged(heights.about_zero.sqrt()), length(b.iter().map(|x| x.hi)));
    // ‖|Q̂|‖ ≤ √(pq) up to η
    let root = 1.1 * ((p * q) as f64).sqrt();
    // ‖Q̂ − WS‖ of the products; ‖Q̂‖ ≤ 1.05
    let stray = enlarged(1.1 * (of_u.stray + of_v.stray) + of_u.stray * of_v.stray);
    let lanes = grid.v.len().div_ceil(LANES);
    let summed = UNIT * (1.1 * running(lanes) + 300.0 + 4.0 * grid.u.len() as f64) * root;
    let tau = enlarged((summed + stray) * z);
    let left = enlarged((eta * moved + tau) / (1.0 - eta));
    let coefficients = product(of_u, of_v, b, q).into_iter().zip(terms(p, q)).map(|(c, (i, j))| {
        let norm = |row: &[Ball]| length(row.iter().map(|x| x.modulus()));
        c.widened(left * norm(&of_u.rows[i]) * norm(&of_v.rows[j]))
    });
    let (rss, ..) = separable.residuals(grid, b, Precision::DoubleDouble, false);
    // residuals as computed are off by the rounding of the pass, by b̂, and by E
    let pass = UNIT * ((8.0 * p as f64 + running(q) + 16.0) * root * moved + 4.0 * z);
    let off = enlarged(pass + 1.1 * left + stray * (moved + left));
    let relative = UNIT * (80.0 * grid.v.len() as f64 + grid.u.len() as f64 + 64.0) + f64::EPSILON;
    Some(Proved {
        coefficients: coefficients.collect(),
        leverages: terms(p, q).map(|(i, j)| of_u.leverages[i] * of_v.leverages[j]).collect(),
        rss: Ball::new(Dd::from(rss), enlarged(relative * rss + 2.0 * off * rss.sqrt() + off * off)),
    })
}

fn terms(p: usize, q: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..p).flat_map(move |i| (0..q).map(move |j| (i, j)))
}

/// `(P_u ⊗ P_v) b`.
fn product(u: &OfAxis, v: &OfAxis, b: &[Dd], q: usize) -> Vec<Ball> {
    // rows of v first
    let along: Vec<Ball> = b
        .chunks(q)
        .flat_map(|b| v.rows.iter().enumerate().map(|(j, row)| dot(row, b[j..].iter().map(|&x| Ball::from(x)))))
        .collect();
    let column = |i: usize, j: usize| along[i * q + j..].iter().step_by(q).copied();
    terms(u.rows.len(), q).map(|(i, j)| dot(&u.rows[i], column(i, j))).collect()
}

impl OfAxis {
    fn new(axis: &Axis, factor: &AxisFactor, positions: &[f64]) -> Option<Self> {
        let Axis::Polynomial { mapping, size, .. } = axis else { return None };
        let (n, m) = (*size, positions.len());
        if !on_unit(*mapping, [positions[0], positions[m - 1]], n - 1) {
            return None;
        }
        let (q, s) = (factor.q(), triangular::inverse_upper(&factor.r));
        let spread = length(s.column_iter().map(|column| column.iter().map(|x| x.hi.abs()).sum::<f64>()));
        let stray = enlarged((m as f64).sqrt() * UNIT * (10.0 * n as f64 + polynomials(n)) * spread);
        let scalar =
            |a: usize, b: usize| q.column(a).iter().zip(q.column(b).iter()).fold(Dd::ZERO, |sum, (&a, &b)| sum + a * b);
        let m_hat = DMatrix::from_fn(n, n, |i, j| if i <= j { scalar(i, j) } else { Dd::ZERO });
        let error = 2.2 * stray + stray * stray + 10.0 * (m * n) as f64 * UNIT;
        let eta = NearIdentity::new(&m_hat, error).distance();
        let inverse = change::of_axis(axis)?;
        let entry =
            |i: usize, j: usize| (i..=j).fold(Ball::ZERO, |sum, k| sum + inverse[(i, k)] * Ball::from(s[(k, j)]));
        let rows: Vec<Vec<Ball>> = (0..n).map(|i| (i..n).map(|j| entry(i, j)).collect()).collect();
        let leverage = |row: &Vec<Ball>| {
            let square = dot(row, row.iter().copied());
            square.widened(eta / (1.0 - eta) * square.modulus())
        };
        Some(OfAxis { leverages: rows.iter().map(leverage).collect(), rows, eta, stray })
    }
}
