//! Variances that are not equal, estimated by restricted maximum likelihood.
//!
//! Node k has variance `σ²/ωₖ`. In the coordinates of plain least squares (orthonormal rows qₖ and
//! residuals bₖ) the restricted likelihood of weights ω is
//!
//! ```text
//! ln L = ½ Σ ln ω − ½ ln det QᵀΩQ − ½(m − n) ln RSS
//! ```

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use flankfit_numerics::{
    cancel::{self, Asking},
    qr_with_rhs,
    root::root,
    triangular,
};

/// Orthonormal rows and residuals of least squares, by counted node.
pub(crate) struct Rows<'a> {
    pub n: usize,
    pub q: &'a [f64],
    pub residuals: &'a [f64],
}

/// Weighted least squares in these coordinates.
struct Weighted {
    r: DMatrix<f64>,
    step: Vec<f64>,
}

impl Rows<'_> {
    fn solved(&self, omega: impl Fn(usize) -> f64) -> Option<Weighted> {
        let n = self.n;
        let mut gram = DMatrix::<f64>::zeros(n, n);
        let (mut right, mut squares) = (vec![0.0; n], 0.0);
        for (k, (row, b)) in self.q.chunks_exact(n).zip(self.residuals).asking(n * n).enumerate() {
            let w = omega(k);
            squares += w * b * b;
            for (j, &x) in row.iter().enumerate() {
                right[j] += w * x * b;
                gram.column_mut(j).iter_mut().zip(&row[..=j]).for_each(|(to, y)| *to += w * x * y);
            }
        }
        let r = triangular::cholesky(&gram)?;
        triangular::solve_upper_transposed(&r, &mut right);
        let rss = squares - right.iter().map(|x| x * x).sum::<f64>();
        triangular::solve_upper(&r, &mut right);
        (rss > 0.0).then_some(Weighted { r, step: right })
    }

    /// ln L of standard deviations that go as the exponent `delta` of the places with these
    /// logarithms. Steep ones make weights of many orders of magnitude, so that the rows are
    /// triangularised, the heaviest first (Powell and Reid 1969).
    fn likelihood(&self, logs: &[f64], ascending: &[usize], delta: f64) -> Option<f64> {
        let (m, n) = (logs.len(), self.n);
        let place = |i: usize| ascending[if delta < 0.0 { m - 1 - i } else { i }];
        let root = |i: usize| libm::exp(-delta * logs[place(i)]);
        let weighted = DMatrix::from_fn(m, n, |i, j| root(i) * self.q[place(i) * n + j]);
        let right = DVector::from_fn(m, |i, _| root(i) * self.residuals[place(i)]);
        cancel::every(2 * m * n * n, 0);
        let found = qr_with_rhs(weighted, right);
        let determinant: f64 = (0..n).map(|i| libm::log(found.r[(i, i)].abs())).sum();
        let volume = -delta * logs.iter().sum::<f64>();
        let ln = volume - determinant - 0.5 * self.freedom() * libm::log(found.rss);
        Some(ln).filter(|ln| ln.is_finite())
    }

    fn freedom(&self) -> f64 {
        (self.residuals.len() - self.n) as f64
    }
}

/// Relative change of variances at which the iteration ends, and rounds at most.
const SETTLED: f64 = 1e-10;
const ROUNDS: usize = 1000;

/// Weights of the groups, that of the first being 1; `None` where a group's residuals vanish or
/// the iteration does not settle. `group` has the group of each counted node.
///
/// At the maximum `σ_g² = Σ r²/Σ(1 − h)` over each group, h being the leverages of the weighted
/// fit: this is iterated.
pub(crate) fn groups(rows: &Rows, group: &[i64]) -> Option<BTreeMap<i64, f64>> {
    let mut variance: BTreeMap<i64, f64> = group.iter().map(|&g| (g, 1.0)).collect();
    if variance.len() == 1 {
        return Some(variance);
    }
    for _ in 0..ROUNDS {
        cancel::checkpoint();
        let found = rows.solved(|k| 1.0 / variance[&group[k]])?;
        let mut sums: BTreeMap<i64, (f64, f64)> = BTreeMap::new();
        let mut turned = vec![0.0; rows.n];
        for (k, (row, b)) in rows.q.chunks_exact(rows.n).zip(rows.residuals).enumerate() {
            turned.copy_from_slice(row);
            triangular::solve_upper_transposed(&found.r, &mut turned);
            let leverage = turned.iter().map(|x| x * x).sum::<f64>() / variance[&group[k]];
            let residual = b - row.iter().zip(&found.step).map(|(x, s)| x * s).sum::<f64>();
            let sum = sums.entry(group[k]).or_default();
            *sum = (sum.0 + residual * residual, sum.1 + 1.0 - leverage);
        }
        let mut moved = 0.0f64;
        for (g, (squares, free)) in sums {
            let next = squares / free;
            if !(free > 1e-9 && next > 0.0 && next.is_finite()) {
                return None;
            }
            moved = moved.max((next / variance[&g] - 1.0).abs());
            variance.insert(g, next);
        }
        if moved < SETTLED {
            let first = *variance.values().next()?;
            return Some(variance.into_iter().map(|(g, v)| (g, first / v)).collect());
        }
    }
    None
}

/// Exponents that are looked at.
const STEEPEST: f64 = 6.0;
const STEPS: usize = 48;
/// Relative width at which golden section ends, well above where the likelihood is flat to
/// rounding.
const RESOLVED: f64 = 1e-5;

/// Exponent δ of standard deviations proportional to |x|^δ; `None` if no δ between ± 6 is likelier
/// than its neighbours. `logs` holds the logarithm of the ratio of each counted node's place to
/// their geometric mean.
pub(crate) fn exponent(rows: &Rows, logs: &[f64]) -> Option<f64> {
    let mut ascending: Vec<usize> = (0..logs.len()).collect();
    ascending.sort_by(|&i, &j| logs[i].total_cmp(&logs[j]).then(rows.residuals[i].total_cmp(&rows.residuals[j])));
    let likelihood = |delta: f64| rows.likelihood(logs, &ascending, delta);
    let place = |k: usize| STEEPEST * (2.0 * k as f64 / STEPS as f64 - 1.0);
    let found: Vec<f64> = (0..=STEPS).map(|k| likelihood(place(k)).unwrap_or(f64::NEG_INFINITY)).collect();
    let best = (0..=STEPS).max_by(|&a, &b| found[a].total_cmp(&found[b]))?;
    if best == 0 || best == STEPS || !found[best].is_finite() {
        return None;
    }
    // golden section, as far as the likelihood distinguishes places
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut low, mut high) = (place(best - 1), place(best + 1));
    while high - low > RESOLVED {
        let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
        if likelihood(a)? > likelihood(b)? { high = b } else { low = a }
    }
    let (low, high) = (low - RESOLVED, high + RESOLVED);
    let slope = |delta: f64| slope(rows, logs, delta).unwrap_or(f64::NAN);
    let found = root([(low, slope(low)), (high, slope(high))], |_| f64::EPSILON, slope);
    Some(found.unwrap_or(0.5 * (low + high)))
}

/// The derivative of the restricted likelihood of the exponent, `Σ ln x [(m − n) ω r²/RSS − (1 −
/// h)]` with residuals and leverages of the weighted fit: 0 at the maximum, and so determines it to
/// the last digits, where the likelihood itself is flat.
fn slope(rows: &Rows, logs: &[f64], delta: f64) -> Option<f64> {
    let omega = |k: usize| libm::exp(-2.0 * delta * logs[k]);
    let found = rows.solved(omega)?;
    let mut turned = vec![0.0; rows.n];
    let (mut squares, mut moment, mut free) = (0.0, 0.0, 0.0);
    for (k, (row, b)) in rows.q.chunks_exact(rows.n).zip(rows.residuals).enumerate() {
        turned.copy_from_slice(row);
        triangular::solve_upper_transposed(&found.r, &mut turned);
        let w = omega(k);
        let leverage = w * turned.iter().map(|x| x * x).sum::<f64>();
        let residual = b - row.iter().zip(&found.step).map(|(x, s)| x * s).sum::<f64>();
        let square = w * residual * residual;
        squares += square;
        moment += logs[k] * square;
        free += logs[k] * (1.0 - leverage);
    }
    Some(rows.freedom() * moment / squares - free)
}
