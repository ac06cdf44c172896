//! Lack of fit: the terms of the next order, and a smooth process.
//!
//! The terms of the next order are tested by F. The score of a Gaussian process with a squared
//! exponential covariance is `‖Φᵀr‖²/‖r‖²`, Φ its functions; its first four moments follow from
//! traces, and a Pearson distribution with them gives the tail.

use super::{
    LEVEL, SUSPICIOUS,
    sites::{Seen, Sites},
};
use crate::result::MissingShape;
use flankfit_numerics::{
    distribution::{
        fisher,
        pearson::{self, Moments},
    },
    matvec,
};

/// Degrees of freedom that terms of the next order leave to the noise.
const LEAST_FREEDOM: f64 = 3.0;
/// Share of the squares that is noise at least.
const LEAST_NOISE: f64 = 0.01;
/// F below which no number of terms is significant.
const SMALL: f64 = 1.2;

/// A shape of the residuals.
pub(crate) struct Lack {
    pub shape: MissingShape,
    pub p: f64,
    /// Its root mean square at the nodes, in heights of weight 1.
    pub rms: f64,
    /// Root mean square of error and shape over the standard error, of fitted heights at the nodes.
    pub factor: f64,
}

/// Tests the terms of the next order, and without them a smooth shape.
pub(crate) fn lack(sites: &Sites, seen: &Seen) -> Option<Lack> {
    next_order(sites, seen).or_else(|| smooth(sites, seen))
}

impl Lack {
    /// With the squares of the shape over all nodes, and the variance of the noise.
    fn new(shape: MissingShape, p: f64, squares: f64, variance: f64, (sites, seen): (&Sites, &Seen)) -> Self {
        let squares = squares.max(0.0);
        let columns = sites.q.len() as f64;
        let assumed = seen.variance(columns);
        let factor = ((columns * variance + squares) / (columns * assumed)).sqrt();
        Lack { shape, p, rms: (squares / seen.nodes).sqrt(), factor }
    }
}

fn next_order(sites: &Sites, seen: &Seen) -> Option<Lack> {
    let (count, freedom) = (sites.next.len() as f64, sites.freedom() - sites.next.len() as f64);
    if count == 0.0 || freedom < LEAST_FREEDOM {
        return None;
    }
    let squares: f64 = sites.next.iter().map(|column| matvec::dot(column, &seen.sums).powi(2)).sum();
    let variance = (seen.rss - squares).max(f64::EPSILON * seen.rss) / freedom;
    let f = squares / (count * variance);
    if f < SMALL {
        return None;
    }
    let p = fisher::upper_tail(f, count, freedom);
    (p < LEVEL).then(|| Lack::new(MissingShape::NextOrder, p, squares - count * variance, variance, (sites, seen)))
}

fn smooth(sites: &Sites, seen: &Seen) -> Option<Lack> {
    let score: f64 = sites.smooth.iter().map(|column| matvec::dot(column, &seen.sums).powi(2)).sum();
    let (share, freedom, gram) = (score / seen.rss, sites.freedom(), &sites.gram);
    let (t1, t2) = (gram.trace(), gram.norm_squared());
    let mean = t1 / freedom;
    let rest = t2 - t1 * mean;
    let variance = 2.0 * rest / (freedom * (freedom + 2.0));
    if !(share > mean + SUSPICIOUS * variance.sqrt()) {
        return None;
    }
    let square = gram * gram;
    let moments = Moments::of_ratio([t1, t2, square.dot(gram), square.norm_squared()], freedom)?;
    let p = pearson::upper_tail(share, &moments);
    // variances of noise and process, of which score and squares have these means
    let process = (score - seen.rss * mean) / rest;
    let noise = (seen.rss - process * t1).max(LEAST_NOISE * seen.rss) / freedom;
    (p < LEVEL).then(|| Lack::new(MissingShape::Smooth, p, process * t1, noise, (sites, seen)))
}
