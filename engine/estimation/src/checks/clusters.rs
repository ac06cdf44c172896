//! Nodes of low weight of a robust fit that lie together.
//!
//! A robust fit gives up nodes that contradict the others. Gross errors lie anywhere; nodes that
//! were given up side by side are a part of the surface that the model does not follow, or a region
//! that was measured wrongly. The number of pairs of neighbours among them is compared with that of
//! as many nodes drawn at random.

use super::LEVEL;
use crate::{
    data::{Nodes, Sample},
    error_model::lines::{Lines, Measure},
    spec::Along,
};

/// Weight below which a node is given up.
const LOW: f64 = 0.5;

/// A cluster of nodes of low weight.
pub(crate) struct Cluster {
    /// Number of nodes of low weight, and their share.
    pub count: usize,
    pub share: f64,
    /// Pairs of neighbours among them, and the number that is expected of as many nodes at random.
    pub pairs: usize,
    pub expected: f64,
    pub p: f64,
    /// Mean place of the nodes that have such a neighbour.
    pub place: Vec<f64>,
    /// Their mean residual.
    pub residual: f64,
}

/// Tests the nodes with weights below a half; weights and residuals are by counted node.
pub(crate) fn cluster(sample: &Sample, nodes: &Nodes, weights: &[f64], residuals: &[f64]) -> Option<Cluster> {
    let low: Vec<bool> = weights.iter().map(|w| *w < LOW).collect();
    let count = low.iter().filter(|low| **low).count();
    if count < 2 {
        return None;
    }
    let all = neighbours(sample, nodes);
    let (m, k) = (weights.len() as f64, count as f64);
    let expected = all.len() as f64 * k * (k - 1.0) / (m * (m - 1.0));
    let found: Vec<&[usize; 2]> = all.iter().filter(|pair| pair.iter().all(|&k| low[k])).collect();
    let pairs = found.len();
    if (pairs as f64) <= expected {
        return None;
    }
    let p = poisson_tail(pairs, expected);
    if p >= LEVEL {
        return None;
    }
    let mut members: Vec<usize> = found.iter().copied().flatten().copied().collect();
    members.sort_unstable();
    members.dedup();
    let mean = |of: &dyn Fn(usize) -> f64| members.iter().map(|&k| of(k)).sum::<f64>() / members.len() as f64;
    let mut place = vec![mean(&|k| sample.place(k).0)];
    if matches!(nodes, Nodes::Grid(_)) {
        place.push(mean(&|k| sample.place(k).1));
    }
    let residual = mean(&|k| residuals[k]);
    Some(Cluster { count, share: k / m, pairs, expected, p, place, residual })
}

/// P(X ≥ count) of a Poisson distribution, for counts above its mean: that of pairs at random is
/// narrower.
fn poisson_tail(count: usize, mean: f64) -> f64 {
    let first = count as f64;
    let mut term = libm::exp(first * libm::log(mean) - mean - libm::lgamma(first + 1.0));
    let (mut sum, mut next) = (0.0, first);
    while term > f64::EPSILON * sum {
        sum += term;
        next += 1.0;
        term *= mean / next;
    }
    sum
}

/// Pairs of neighbours along the lines of a grid or curve.
fn neighbours(sample: &Sample, nodes: &Nodes) -> Vec<[usize; 2]> {
    let courses: &[Along] = match nodes {
        Nodes::Curve(_) => &[Along::Order],
        Nodes::Grid(_) => &[Along::U, Along::V],
        Nodes::Scattered(_) | Nodes::Matrix(_) => &[],
    };
    let mut pairs = Vec::new();
    for &along in courses {
        let lines = Lines::new(nodes, sample, along, None, Measure::Steps);
        let linked = lines.nodes.windows(2).zip(&lines.steps[1..]).filter(|(_, step)| step.is_finite());
        pairs.extend(linked.map(|(pair, _)| [pair[0], pair[1]]));
    }
    pairs
}
