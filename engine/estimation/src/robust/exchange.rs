//! Exchanges of one node inside a trimmed sum for one outside (Hawkins 1994).
//!
//! Concentration steps end in many places: where the h smallest residuals belong to the nodes that
//! were fitted. Most of them can still be left by an exchange. Without node i and with node j the
//! least sum of squares changes by `uᵀM⁻¹u`, `u = (rᵢ, rⱼ)`, `M = [[hᵢᵢ − 1, hᵢⱼ],
//! [hᵢⱼ, 1 + hⱼⱼ]]`, h the products of rows with the inverse of the subset's normal equations
//! between. Only nodes next to the limit between inside and outside can lower it.

use super::rows::{Normal, Rows, dot};
use flankfit_numerics::cancel::Asking;

/// Nodes that are tried on either side: so many, and this often the number of coefficients.
const TRIED: [usize; 2] = [60, 4];
/// Least gain of an exchange, in variances: less moves no coefficient by a thousandth of its
/// standard error.
const GAIN: f64 = 1e-6;

/// The subset after the exchange that lowers its `sum` most; `None` where none does. `x` is its
/// fit.
pub(super) fn better(rows: &Rows, kept: &[usize], x: &[f64], sum: f64) -> Option<Vec<usize>> {
    let (m, n) = (rows.count(), rows.n);
    let r = rows.residuals(x);
    let mut inside = vec![false; m];
    kept.iter().for_each(|&k| inside[k] = true);
    let tried = TRIED[0] + TRIED[1] * n;
    let nearest = |mut side: Vec<usize>, sign: f64| {
        side.sort_unstable_by(|&a, &b| (sign * r[a].abs()).total_cmp(&(sign * r[b].abs())).then(a.cmp(&b)));
        side.truncate(tried);
        side
    };
    let out = nearest(kept.to_vec(), -1.0);
    let into = nearest((0..m).filter(|&k| !inside[k]).collect(), 1.0);
    let mut q = Vec::with_capacity(kept.len() * n);
    kept.iter().asking(n).for_each(|&k| q.extend_from_slice(rows.row(k)));
    let normal = Normal::new(n, &q, &vec![1.0; kept.len()])?;
    let white = |side: &[usize]| -> Vec<Vec<f64>> {
        side.iter().asking(n * n).map(|&k| normal.whitened(rows.row(k))).collect()
    };
    let (white_out, white_into) = (white(&out), white(&into));
    let own: Vec<f64> = white_into.iter().map(|y| dot(y, y)).collect();
    let mut best = (-GAIN * sum / (kept.len() - n) as f64, None);
    for (i, y) in out.iter().zip(&white_out).asking(n * into.len()) {
        let left = 1.0 - dot(y, y);
        for ((j, other), own) in into.iter().zip(&white_into).zip(&own) {
            let (cross, grown) = (dot(y, other), 1.0 + own);
            let determinant = left * grown + cross * cross;
            let change = (left * r[*j] * r[*j] + 2.0 * r[*i] * r[*j] * cross - grown * r[*i] * r[*i]) / determinant;
            if change < best.0 {
                best = (change, Some((*i, *j)));
            }
        }
    }
    let (i, j) = best.1?;
    let mut subset: Vec<usize> = kept.iter().copied().filter(|&k| k != i).chain([j]).collect();
    subset.sort_unstable();
    Some(subset)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robust::rows::weighted_solution;

    /// The change that is predicted is that of the two fits.
    #[test]
    fn an_exchange_lowers_the_sum_as_predicted() {
        let (m, n, h) = (14, 2, 9);
        let q: Vec<f64> = (0..m).flat_map(|k| [1.0, f64::from(k as u8)]).collect();
        let b: Vec<f64> = (0..m).map(|k| (2.3 * f64::from(k as u8).powi(2)).sin()).collect();
        let rows = Rows { n, q, b };
        let fit = |subset: &[usize]| {
            let weights: Vec<f64> = (0..m).map(|k| f64::from(u8::from(subset.contains(&k)))).collect();
            let x = weighted_solution(n, &rows.q, &weights, &rows.b).unwrap();
            let r = rows.residuals(&x);
            (subset.iter().map(|&k| r[k] * r[k]).sum::<f64>(), x)
        };
        let mut subset: Vec<usize> = (0..h).collect();
        let mut last = f64::INFINITY;
        let mut exchanges = 0;
        loop {
            let (sum, x) = fit(&subset);
            assert!(sum < last, "{sum} {last}");
            last = sum;
            // the best of all exchanges, by fitting each
            let mut least = sum * (1.0 - GAIN / (h - n) as f64);
            let mut found = None;
            for i in 0..h {
                for j in (0..m).filter(|j| !subset.contains(j)) {
                    let mut other = subset.clone();
                    other[i] = j;
                    other.sort_unstable();
                    if fit(&other).0 < least {
                        (least, found) = (fit(&other).0, Some(other));
                    }
                }
            }
            let got = better(&rows, &subset, &x, sum);
            assert_eq!(got, found);
            match got {
                Some(next) => subset = next,
                None => break,
            }
            exchanges += 1;
        }
        assert!(exchanges > 0);
    }
}
