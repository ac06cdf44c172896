//! Variance that depends on the place: Koenker's test (Journal of Econometrics 17, 1981).
//!
//! Squared residuals over 1 − h, whose means are equal if the variance is, are regressed on u² and
//! v², and with a smaller share of the false alarms on u and v; the spread of the squares
//! themselves studentises the slopes, so that long tails are no alarm. Where few nodes determine a
//! coefficient the squares are correlated by the projection; so the slope over `Σ r²` must be
//! significant as well, whose distribution for normal errors follows from its moments. Scores of a
//! robust estimate are bounded and not normal: they are tested from 3.5 nodes a coefficient on.

use super::{
    LEVEL,
    sites::{Regressor, Seen, Sites},
};
use crate::{result::LargerErrors, spec::Along};
use flankfit_numerics::{
    distribution::{
        normal,
        pearson::{self, Moments},
    },
    matvec,
};
use nalgebra::DMatrix;

/// Degrees of freedom from which on the normal distribution of a slope is near enough.
const LEAST_FREEDOM: f64 = 10.0;
/// Nodes a coefficient from which on the squares of scores are hardly correlated.
const LEAST_OF_SCORES: f64 = 3.5;
/// Greatest studentised slope that no share makes significant.
const SMALL: f64 = 2.4;

/// Share of the mean variance that a place has at least.
const LEAST_VARIANCE: f64 = 0.05;

/// A variance that depends on the place.
pub(crate) struct Uneven {
    pub along: Along,
    pub larger: LargerErrors,
    pub p: f64,
    /// Factor by which standard errors of heights are too small at the worst site, if the variance
    /// follows the regressor.
    pub factor: f64,
}

/// Tests the variance; `scores` are those of a robust estimate, which are never normal.
pub(crate) fn uneven(sites: &Sites, seen: &Seen, scores: bool) -> Option<Uneven> {
    let columns = sites.q.len() as f64;
    if seen.nodes - columns < LEAST_FREEDOM || (scores && seen.nodes < LEAST_OF_SCORES * columns) {
        return None;
    }
    let weighed: Vec<f64> = seen.squares.iter().zip(&sites.share).map(|(square, share)| square * share).collect();
    let fourths: f64 = seen.fourths.iter().zip(&sites.share).map(|(fourth, share)| fourth * share * share).sum();
    let count: f64 = sites.count.iter().zip(&sites.share).filter(|(_, share)| **share > 0.0).map(|(n, _)| n).sum();
    let sum: f64 = weighed.iter().sum();
    let spread = ((fourths - sum * sum / count) / (count - 1.0)).sqrt();
    let slope =
        |one: &Regressor| one.centred.iter().zip(&weighed).map(|(x, w)| x * w).sum::<f64>() / (one.length * spread);
    let found = sites.regressors.iter().filter_map(|one| {
        let t = slope(one);
        let p = |tail: f64| 2.0 * tail / one.part;
        let studentised = if t.abs() > SMALL { p(normal::upper_tail(t.abs())) } else { 1.0 };
        let normal = if scores || studentised >= LEVEL { 0.0 } else { p(normal_tail(sites, seen, one, t.signum())?) };
        let p = studentised.max(normal);
        (p < LEVEL).then_some((one, t, p))
    });
    let (one, t, p) = found.min_by(|a, b| a.2.total_cmp(&b.2))?;
    let larger = match (one.square, t > 0.0) {
        (true, true) => LargerErrors::Ends,
        (true, false) => LargerErrors::Middle,
        (false, true) => LargerErrors::High,
        (false, false) => LargerErrors::Low,
    };
    let slope = t * spread / one.length;
    let mean = sum / count;
    let variances = one.centred.iter().map(|x| (mean + slope * x).max(LEAST_VARIANCE * mean)).collect();
    Some(Uneven { along: one.along, larger, p, factor: factor(sites, variances, seen.variance(columns)) })
}

/// The tail of `Σ dr²/Σ r²` for normal errors, d a power of the coordinate over 1 − h, towards one
/// side: with D their diagonal matrix and P the projection on the columns from traces of powers of
/// (I − P)D.
fn normal_tail(sites: &Sites, seen: &Seen, one: &Regressor, side: f64) -> Option<f64> {
    let d: Vec<f64> = one.centred.iter().zip(&sites.share).map(|(x, share)| side * x * share).collect();
    let n = sites.q.len();
    let power = |j: i32| d.iter().map(|d| d.powi(j)).collect::<Vec<f64>>();
    let between = |j: i32| {
        let power = power(j);
        let scaled: Vec<Vec<f64>> =
            sites.q.iter().map(|q| q.iter().zip(&power).map(|(q, d)| q * d).collect()).collect();
        DMatrix::from_fn(n, n, |i, k| matvec::dot(&sites.q[i], &scaled[k]))
    };
    let [b1, b2, b3, b4] = [1, 2, 3, 4].map(between);
    let square = &b1 * &b1;
    let [s1, s2, s3, s4] = [1, 2, 3, 4].map(|j| matvec::dot(&power(j), &sites.count));
    let traces = [
        s1 - b1.trace(),
        s2 - 2.0 * b2.trace() + b1.norm_squared(),
        s3 - 3.0 * b3.trace() + 3.0 * b2.dot(&b1) - square.dot(&b1),
        s4 - 4.0 * (b4.trace() - b3.dot(&b1) + b2.dot(&square)) + 2.0 * b2.norm_squared() + square.norm_squared(),
    ];
    let moments = Moments::of_ratio(traces, seen.nodes - n as f64)?;
    let ratio = matvec::dot(&d, &seen.squares) / seen.squares.iter().sum::<f64>();
    Some(pearson::upper_tail(ratio, &moments))
}

/// Greatest ratio of the standard errors of heights by the variance of each site to those by one
/// variance.
fn factor(sites: &Sites, variances: Vec<f64>, one: f64) -> f64 {
    let row = |site: usize| sites.q.iter().map(move |q| q[site]);
    let ratio = |site: usize| {
        let sum: f64 = variances
            .iter()
            .enumerate()
            .map(|(k, v)| v * row(site).zip(row(k)).map(|(a, b)| a * b).sum::<f64>().powi(2))
            .sum();
        sum / (one * row(site).map(|x| x * x).sum::<f64>())
    };
    (0..sites.count.len()).map(ratio).fold(0.0, f64::max).sqrt()
}
