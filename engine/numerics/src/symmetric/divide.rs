//! Eigenvectors of a symmetric tridiagonal matrix by division: two halves and what joins them, a
//! matrix of rank 1 (Cuppen 1981), with the vectors of Gu and Eisenstat (1994), which are
//! orthogonal however close eigenvalues lie.

use nalgebra::DMatrix;

use super::secular;
use crate::{cancel, matvec::product, tridiagonal::ql};

/// Up to this size QL steps are as quick.
const SMALL: usize = 24;

/// Half in which a vector is other than 0.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Half {
    Upper,
    Lower,
    Both,
}

/// Eigenvalues, ascending, and eigenvectors of the tridiagonal matrix with `diagonal` and
/// off-diagonal entries `off_diagonal`; `None` if an iteration does not converge.
pub(super) fn eigen(diagonal: Vec<f64>, off_diagonal: &[f64]) -> Option<(Vec<f64>, DMatrix<f64>)> {
    let n = diagonal.len();
    if n <= SMALL {
        return by_steps(diagonal, off_diagonal);
    }
    cancel::checkpoint();
    let middle = n / 2;
    let joint = off_diagonal[middle - 1];
    let (mut upper, mut lower) = (diagonal[..middle].to_vec(), diagonal[middle..].to_vec());
    upper[middle - 1] -= joint.abs();
    lower[0] -= joint.abs();
    let upper = eigen(upper, &off_diagonal[..middle - 1])?;
    let lower = eigen(lower, &off_diagonal[middle..])?;
    Some(joined(upper, lower, joint))
}

fn by_steps(mut d: Vec<f64>, off_diagonal: &[f64]) -> Option<(Vec<f64>, DMatrix<f64>)> {
    let n = d.len();
    let mut e = off_diagonal.to_vec();
    e.resize(n, 0.0);
    let mut vectors = DMatrix::<f64>::identity(n, n);
    ql(&mut d, &mut e, |i, c, s| {
        let (left, right) = vectors.as_mut_slice()[i * n..(i + 2) * n].split_at_mut(n);
        for (x, y) in left.iter_mut().zip(right) {
            (*x, *y) = (c * *x - s * *y, s * *x + c * *y);
        }
    })?;
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| d[i].total_cmp(&d[j]));
    let sorted = DMatrix::from_fn(n, n, |i, j| vectors[(i, order[j])]);
    Some((order.iter().map(|&i| d[i]).collect(), sorted))
}

/// The halves with their joint `b`: `diag(d) + 2|b| zzᵀ` in their eigenvectors.
fn joined(
    (upper, q_upper): (Vec<f64>, DMatrix<f64>),
    (lower, q_lower): (Vec<f64>, DMatrix<f64>),
    b: f64,
) -> (Vec<f64>, DMatrix<f64>) {
    let (p, n) = (upper.len(), upper.len() + lower.len());
    let rho = 2.0 * b.abs();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let mut d: Vec<f64> = upper.into_iter().chain(lower).collect();
    let first = half.copysign(b);
    let mut z: Vec<f64> =
        q_upper.row(p - 1).iter().map(|x| x * half).chain(q_lower.row(0).iter().map(|x| x * first)).collect();
    let mut q = DMatrix::zeros(n, n);
    q.view_mut((0, 0), (p, p)).copy_from(&q_upper);
    q.view_mut((p, p), (n - p, n - p)).copy_from(&q_lower);
    let mut halves: Vec<Half> = (0..n).map(|j| if j < p { Half::Upper } else { Half::Lower }).collect();
    let kept = deflated(&mut d, &mut z, rho, &mut q, &mut halves);
    let (values, inner) = rank_one(&kept, &d, &z, rho);
    let turned = [(Half::Lower, 0, p), (Half::Upper, p, n - p)].map(|(absent, from, rows)| {
        let present: Vec<usize> = (0..kept.len()).filter(|&i| halves[kept[i]] != absent).collect();
        let left = DMatrix::from_fn(rows, present.len(), |i, j| q[(from + i, kept[present[j]])]);
        let right = DMatrix::from_fn(present.len(), kept.len(), |i, j| inner[(present[i], j)]);
        product(&left, &right)
    });
    // kept ones by their new values and vectors, the others as they are
    let mut is_kept = vec![None; n];
    kept.iter().enumerate().for_each(|(i, &j)| is_kept[j] = Some(i));
    for (i, &j) in kept.iter().enumerate() {
        d[j] = values[i];
    }
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| d[i].total_cmp(&d[j]));
    let mut vectors = DMatrix::zeros(n, n);
    for (mut to, &j) in vectors.column_iter_mut().zip(&order) {
        match is_kept[j] {
            None => to.copy_from(&q.column(j)),
            Some(i) => {
                to.rows_mut(0, p).copy_from(&turned[0].column(i));
                to.rows_mut(p, n - p).copy_from(&turned[1].column(i));
            }
        }
    }
    (order.iter().map(|&j| d[j]).collect(), vectors)
}

/// Sets aside the eigenvalues that the rank-one change does not move: entries of z that are 0 to
/// rounding, and one of two neighbours whose eigenvalues are equal to rounding, after a rotation.
/// Returns the indices of the others by ascending d.
fn deflated(d: &mut [f64], z: &mut [f64], rho: f64, q: &mut DMatrix<f64>, halves: &mut [Half]) -> Vec<usize> {
    let n = d.len();
    let largest = |x: &[f64]| x.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let tolerance = 8.0 * f64::EPSILON * largest(d).max(largest(z));
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| d[i].total_cmp(&d[j]));
    let mut kept: Vec<usize> = Vec::with_capacity(n);
    for j in order {
        if rho * z[j].abs() <= tolerance {
            continue;
        }
        let Some(&i) = kept.last() else {
            kept.push(j);
            continue;
        };
        let length = z[i].hypot(z[j]);
        let (c, s) = (z[j] / length, -z[i] / length);
        if ((d[j] - d[i]) * c * s).abs() > tolerance {
            kept.push(j);
            continue;
        }
        (z[i], z[j]) = (0.0, length);
        for row in 0..n {
            let (x, y) = (q[(row, i)], q[(row, j)]);
            (q[(row, i)], q[(row, j)]) = (c * x + s * y, c * y - s * x);
        }
        if halves[i] != halves[j] {
            (halves[i], halves[j]) = (Half::Both, Half::Both);
        }
        (d[i], d[j]) = (d[i] * c * c + d[j] * s * s, d[i] * s * s + d[j] * c * c);
        kept.pop();
        kept.push(j);
    }
    kept
}

/// Eigenvalues and eigenvectors of `diag(d) + ρ zzᵀ`, of the entries `kept` alone.
fn rank_one(kept: &[usize], d: &[f64], z: &[f64], rho: f64) -> (Vec<f64>, DMatrix<f64>) {
    let k = kept.len();
    let d: Vec<f64> = kept.iter().map(|&j| d[j]).collect();
    let weights: Vec<f64> = kept.iter().map(|&j| rho * z[j] * z[j]).collect();
    // column i: dⱼ − λᵢ
    let mut gaps = DMatrix::zeros(k, k);
    let values: Vec<f64> = gaps
        .as_mut_slice()
        .chunks_exact_mut(k.max(1))
        .enumerate()
        .map(|(i, gap)| {
            cancel::every(40 * k, i);
            secular::root(i, &d, &weights, gap)
        })
        .collect();
    // the z of which these λ are exactly the eigenvalues
    let mut exact: Vec<f64> = (0..k).map(|i| -gaps[(i, i)]).collect();
    for (i, gap) in gaps.column_iter().enumerate() {
        for j in (0..k).filter(|j| *j != i) {
            exact[j] *= gap[j] / (d[j] - d[i]);
        }
    }
    for (exact, &j) in exact.iter_mut().zip(kept) {
        *exact = exact.abs().sqrt().copysign(z[j]);
    }
    for mut gap in gaps.column_iter_mut() {
        gap.iter_mut().zip(&exact).for_each(|(gap, z)| *gap = z / *gap);
        let length = gap.norm();
        gap /= length;
    }
    (values, gaps)
}
