//! Nodes one by one: scattered ones, grids with holes or weights, curves, rows of a matrix.

use nalgebra::DMatrix;

use super::{
    Proved,
    change::{Columns, inverse_change},
    dot, length,
    near_identity::{NearIdentity, near_identity},
    rounding::{Rounding, in_range, weight_in_range},
    transposed_product,
};
use crate::{
    data::{Heights, Sample},
    factor::{Precision, Wanted, residual_pass},
    problem::LinearProblem,
};
use flankfit_numerics::{Ball, Dd, ball::enlarged, cancel::Asking, triangular};

/// `None` where the columns are too close to dependent, or numbers out of range.
pub(super) fn proved(linear: &LinearProblem, sample: &Sample, heights: &Heights) -> Option<Proved> {
    let (design, factor) = (linear.design, linear.factor);
    let working = factor.working.as_deref()?;
    let rounding = Rounding::new(design, sample)?;
    let weight = enlarged(heights.weight);
    let largest = working.iter().map(|c| c.hi.abs()).sum::<f64>();
    let size = enlarged(heights.largest_plain + rounding.largest * largest);
    if !in_range(size) || !weight_in_range(weight) {
        return None;
    }
    let s = triangular::inverse_upper(&factor.r);
    let spread = length(s.column_iter().map(|column| column.iter().map(|x| x.hi.abs()).sum::<f64>()));
    let near = near_identity(design, sample, &s, (weight, spread), &rounding);
    let eta = near.distance();
    if !(eta < 0.1) {
        return None;
    }
    let pass = residual_pass(design, sample, working, Precision::DoubleDouble, Wanted::SharpProjection);
    // ‖√Ω r̂‖, and how far r̂ is from the residuals of `working`
    let (residual, stray) = (enlarged(pass.rss.hi.sqrt()), weight.sqrt() * rounding.residual * size);
    let (alpha, error) = transposed_product(&s, &pass.projected);
    let moved = length(alpha.iter().map(|x| x.hi));
    // ‖α − Sᵀρ‖; √(1 + η) ≤ 1.05
    let tau = enlarged(error + spread * rounding.projection * weight.sqrt() * residual + 1.05 * stray);
    let inverse = inverse_change(design)?;
    let p = rows(&inverse, &s);
    let mut coefficients = vec![Ball::ZERO; working.len()];
    for (column, c) in inverse.iter().zip(working) {
        column.iter().for_each(|&(i, x)| coefficients[i] = coefficients[i] + x * Ball::from(*c));
    }
    let left = enlarged((eta * moved + tau) / (1.0 - eta));
    for ((j, c), row) in coefficients.iter_mut().enumerate().zip(&p) {
        *c = (*c + dot(row, alpha[j..].iter().map(|&x| Ball::from(x))))
            .widened(left * length(row.iter().map(|x| x.modulus())));
    }
    let between = [(moved - tau).max(0.0).powi(2) / (1.0 + eta), (moved + tau).powi(2) / (1.0 - eta)];
    let middle = 0.5 * (between[0] + between[1]);
    let around = 0.5 * (between[1] - between[0]) + 1e-8 * between[1];
    let own = rounding.squares * pass.rss.hi + 2.0 * stray * residual + stray * stray;
    Some(Proved {
        coefficients,
        leverages: p
            .iter()
            .enumerate()
            .asking(working.len() * working.len())
            .map(|(j, row)| leverage(j, row, &near))
            .collect(),
        rss: Ball::new(pass.rss, own) - Ball::new(Dd::from(middle), around),
    })
}

/// `P = T⁻¹S`, of row j the entries from j on.
fn rows(inverse: &Columns, s: &DMatrix<Dd>) -> Vec<Vec<Ball>> {
    let n = s.ncols();
    let mut rows: Vec<Vec<Ball>> = (0..n).map(|j| vec![Ball::ZERO; n - j]).collect();
    for j in (0..n).asking(10 * n * n) {
        for (k, column) in inverse.iter().enumerate().take(j + 1) {
            let factor = Ball::from(s[(k, j)]);
            column.iter().for_each(|&(i, x)| rows[i][j - i] = rows[i][j - i] + x * factor);
        }
    }
    rows
}

/// `pᵀM⁻¹p = pᵀ(I − F)p ± ‖p‖²‖F‖²/(1 − ‖F‖)` with F = M − I.
fn leverage(from: usize, row: &[Ball], near: &NearIdentity) -> Ball {
    let square = dot(row, row.iter().copied());
    let (n, eta) = (row.len(), near.distance());
    let mut excess = 0.0;
    for (j, p) in row.iter().enumerate() {
        let column = &near.excess.as_slice()[(from + j) * near.excess.nrows() + from..][..n];
        excess += p.mid.hi * column.iter().zip(row).map(|(f, p)| f * p.mid.hi).sum::<f64>();
    }
    // rounding of that sum, and of p to double, and the radius of p
    let rounding = (2 * n + 16) as f64 * f64::EPSILON * near.excess.norm();
    let left = eta * eta / (1.0 - eta) + near.error + rounding;
    let radius = length(row.iter().map(|p| p.radius));
    let norm = length(row.iter().map(|p| p.modulus()));
    (square - Ball::from(excess)).widened(left * norm * norm + 3.0 * eta * radius * norm)
}
