//! Gross errors among the nodes: externally studentised residuals of plain least squares against
//! Student's t.
//!
//! Nodes are deleted one after the other, the one with the greatest studentised residual first, as
//! long as one exceeds a bound derived from the mean absolute residual, at most a tenth of the
//! nodes and 200. Of many nodes all with at least half of the greatest residual are deleted in one
//! pass, so that a surface that the model does not fit is not searched node by node. All nodes
//! deleted up to the last one that is significant at 0.001 among the m nodes then left are
//! suspected: the generalised test of Rosner (Technometrics 25, 1983). Stopping at the first node
//! that is not significant would let gross errors mask each other: three of 30 σ among 45 nodes
//! were then found in 0.31 of the cases, and are now found in 0.999. A suspected node that the fit
//! of the others explains after all is no longer suspected.
//!
//! In Q's coordinates node k is the row qₖ and least squares the vector b. Deleting a node with
//! residual ρ and leverage h moves b by −q ρ/(1 − h), and q ← (I − qqᵀ)^(−1/2) q makes the rows of
//! the others orthonormal again: one pass over the residuals for each node found (or each group of
//! many), none if there is none.

use crate::{
    data::{Nodes, Sample},
    factor::{Axes, orthonormal_rows},
    problem::{Evidence, LinearProblem, Rows},
    result::{Outliers, SuspectedNode},
};
use flankfit_numerics::{
    Dd,
    cancel::Asking,
    distribution::{Student, normal},
    dot,
};

/// Rate of false alarms of a fit.
const RATE: f64 = 1e-3;
/// At most one node in this many is suspected.
const SHARE: usize = 10;
/// At most so many nodes are suspected.
const MOST: usize = 200;
/// 1 − h below this is 0 up to rounding: without this node its height is undetermined.
const UNDETERMINED: f64 = 1e-10;
/// Residuals below this share of the greatest height are rounding errors.
const ROUNDING: f64 = 1e-10;
/// √(π/2): ratio of σ to the mean absolute value of a normal variable.
const SIGMA_OF_MEAN: f64 = 1.253_314_137_315_500_3;
/// Products `nodes × coefficients²` up to which every node's leverage is computed; above, only
/// those of nodes with at least half the residual that the test requires, and several nodes are
/// deleted at a time.
const CHEAP: usize = 200_000;

/// Returns the nodes suspected of gross errors; `largest` is max √w |z|.
pub(crate) fn outliers(linear: &LinearProblem, largest: f64) -> Option<Outliers> {
    let Evidence::Posted { sample, nodes } = linear.evidence else { return None };
    let (m, n) = (sample.count(), linear.factor.size());
    if m < n + 2 || linear.factor.working.is_none() || is_clean(linear, m, n) {
        return None;
    }
    let rows = match &linear.factor.separable {
        Some(separable) => NodeRows::Axes(&separable.axes),
        None if m.saturating_mul(n * n) <= CHEAP => {
            NodeRows::All(orthonormal_rows(linear.design, linear.factor, sample))
        }
        None => NodeRows::Each(Rows::new(linear.design, sample, &linear.factor.r)),
    };
    Test { linear, sample, rows, floor: ROUNDING * largest }.suspected(nodes)
}

/// Returns the bound for a studentised residual times σ, in units of σ estimated from the mean
/// absolute residual: below it none is significant, since that mean is no greater than the root
/// mean square.
fn limit(quantile: f64, freedom: f64) -> f64 {
    quantile * (freedom / (freedom - 1.0 + quantile * quantile)).sqrt() / SIGMA_OF_MEAN
}

/// Returns σ estimated from the mean absolute residual, which gross errors inflate less than `Σ
/// r²`.
fn sigma_of(sum_abs: f64, count: usize, freedom: f64) -> f64 {
    SIGMA_OF_MEAN * sum_abs / (count as f64 * freedom).sqrt()
}

/// True if the sums alone show that no residual of a full grid exceeds the bound.
fn is_clean(linear: &LinearProblem, m: usize, n: usize) -> bool {
    let Some(separable) = &linear.factor.separable else { return false };
    let freedom = (m - n) as f64;
    let left = 1.0 - separable.axes.u.greatest_leverage() * separable.axes.v.greatest_leverage();
    // Student's quantile is greater than the normal one, and the limit rises with it
    let least = limit(normal::upper_quantile(0.5 * RATE / m as f64), freedom);
    separable.max_abs <= least * sigma_of(separable.sum_abs, m, freedom) * left.max(0.0).sqrt()
}

/// A node that was deleted.
struct Deleted {
    node: usize,
    /// Its row, orthonormalised over the nodes left before its deletion, and the factor by which it
    /// updates the other rows.
    row: Vec<f64>,
    factor: f64,
    /// Change of b by its deletion.
    step: Vec<f64>,
}

struct Test<'a> {
    linear: &'a LinearProblem<'a>,
    sample: &'a Sample<'a>,
    rows: NodeRows<'a>,
    floor: f64,
}

/// Rows of Q.
enum NodeRows<'a> {
    /// Rows of a full grid, as products of those of its axes.
    Axes(&'a Axes),
    /// All rows, if there are few nodes.
    All(Vec<f64>),
    /// Rows computed on request, if there are many nodes.
    Each(Rows<'a>),
}

/// Residuals of all nodes times the root of the weight, and sums over the nodes left.
struct Left {
    residuals: Vec<f64>,
    rss: f64,
    sum_abs: f64,
    count: usize,
    freedom: f64,
}

impl Test<'_> {
    fn suspected(&self, nodes: &Nodes) -> Option<Outliers> {
        let most = (self.sample.count() / SHARE).clamp(1, MOST);
        let mut deleted: Vec<Deleted> = Vec::new();
        let mut found = 0;
        while deleted.len() < most {
            let left = self.left(&deleted);
            if left.freedom < 2.0 {
                break;
            }
            let quantile = Student::new(left.freedom - 1.0).upper_quantile(0.5 * RATE / left.count as f64);
            let least = limit(quantile, left.freedom) * sigma_of(left.sum_abs, left.count, left.freedom);
            let (least, before) = (least.max(self.floor), deleted.len());
            let (mut rss, mut freedom) = (left.rss, left.freedom);
            for k in self.exceeding(&left, &deleted, least).into_iter().take(most - before) {
                if freedom < 2.0 {
                    break;
                }
                let Some((size, next)) = self.without(k, left.residuals[k], &deleted, before) else { continue };
                if size <= least {
                    continue;
                }
                deleted.push(next);
                (rss, freedom) = ((rss - size * size).max(0.0), freedom - 1.0);
                if size > quantile * (rss / freedom).sqrt().max(self.floor) {
                    found = deleted.len();
                }
            }
            if deleted.len() == before {
                break;
            }
        }
        deleted.truncate(found);
        (found > 0).then(|| self.to_result(nodes, &deleted))
    }

    /// Returns the residuals of the fit without the deleted nodes.
    fn left(&self, deleted: &[Deleted]) -> Left {
        let mut image = self.linear.factor.qty.clone();
        for one in deleted {
            image.iter_mut().zip(&one.step).for_each(|(b, step)| *b += Dd::from(*step));
        }
        let mut residuals = self.linear.of_image(&image, true).values.unwrap_or_default();
        if self.sample.weighted() {
            residuals.iter_mut().enumerate().for_each(|(k, r)| *r *= self.sample.w(k).sqrt());
        }
        let gone = deleted.iter().map(|one| residuals[one.node]);
        let (gone_squares, gone_abs) = gone.fold((0.0, 0.0), |(squares, abs), r| (squares + r * r, abs + r.abs()));
        let rss: f64 = residuals.iter().map(|r| r * r).sum();
        let sum_abs: f64 = residuals.iter().map(|r| r.abs()).sum();
        let count = residuals.len() - deleted.len();
        Left {
            rss: (rss - gone_squares).max(0.0),
            sum_abs: (sum_abs - gone_abs).max(0.0),
            count,
            freedom: (count - image.len()) as f64,
            residuals,
        }
    }

    /// Returns the nodes left whose studentised residuals, times σ, exceed `least`, the greatest
    /// first: of few nodes that one alone, of many all with at least half of the greatest. Theirs
    /// are studentised by the leverages in the fit of all nodes, which hardly differ.
    fn exceeding(&self, left: &Left, deleted: &[Deleted], least: f64) -> Vec<usize> {
        let n = self.linear.factor.size();
        let many = left.count.saturating_mul(n * n) > CHEAP;
        let by = if many { &[] } else { deleted };
        let from = if many { 0.5 * least } else { 0.0 };
        let mut found: Vec<(f64, usize)> = Vec::new();
        for (k, residual) in left.residuals.iter().enumerate().asking(n) {
            if residual.abs() <= from || deleted.iter().any(|one| one.node == k) {
                continue;
            }
            let remaining = 1.0 - self.leverage(k, by);
            let size = residual.abs() / remaining.sqrt();
            if remaining > UNDETERMINED && size > least {
                found.push((size, k));
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let half = found.first().map_or(0.0, |first| 0.5 * first.0);
        let together = if many { found.iter().take_while(|one| one.0 >= half).count() } else { 1 };
        found.into_iter().take(together).map(|(_, k)| k).collect()
    }

    /// Returns the studentised residual of node `k`, times σ, and what its deletion changes;
    /// `residual` is that of the fit without the first `before` of the deleted nodes. `None` if its
    /// height is undetermined without it.
    fn without(&self, k: usize, residual: f64, deleted: &[Deleted], before: usize) -> Option<(f64, Deleted)> {
        let row = self.row(k, deleted);
        let remaining = 1.0 - dot(&row, &row);
        if remaining <= UNDETERMINED {
            return None;
        }
        let since = &deleted[before..];
        let moved = if since.is_empty() { Vec::new() } else { self.row(k, &[]) };
        let residual = since.iter().fold(residual, |residual, one| residual - dot(&moved, &one.step));
        let share = residual / remaining;
        let mut step: Vec<f64> = row.iter().map(|q| -q * share).collect();
        for one in deleted.iter().rev() {
            one.turn(&mut step);
        }
        let factor = (1.0 / remaining.sqrt() - 1.0) / (1.0 - remaining).max(f64::MIN_POSITIVE);
        Some((residual.abs() / remaining.sqrt(), Deleted { node: k, row, factor, step }))
    }

    /// Returns the leverage of counted node `k` in the fit of the nodes left.
    fn leverage(&self, k: usize, deleted: &[Deleted]) -> f64 {
        if let (NodeRows::Axes(Axes { u, v, .. }), []) = (&self.rows, deleted) {
            let positions = v.leverages.len();
            return u.leverages[k / positions] * v.leverages[k % positions];
        }
        let row = self.row(k, deleted);
        dot(&row, &row)
    }

    /// Returns the row of counted node `k`, orthonormalised over the nodes left.
    fn row(&self, k: usize, deleted: &[Deleted]) -> Vec<f64> {
        let n = self.linear.factor.size();
        let mut row = match &self.rows {
            NodeRows::All(rows) => rows[k * n..][..n].to_vec(),
            NodeRows::Each(rows) => rows.at(k).0,
            NodeRows::Axes(Axes { u, v, .. }) => {
                let positions = v.leverages.len();
                let (along_u, along_v) = (u.row(k / positions), v.row(k % positions));
                along_u.iter().flat_map(|a| along_v.iter().map(move |b| a * b)).collect()
            }
        };
        deleted.iter().for_each(|one| one.turn(&mut row));
        row
    }

    /// Returns the deleted nodes that deviate significantly from the fit of the others.
    fn to_result(&self, nodes: &Nodes, deleted: &[Deleted]) -> Outliers {
        let left = self.left(deleted);
        let sigma = (left.rss / left.freedom).sqrt().max(self.floor);
        let quantile = Student::new(left.freedom).upper_quantile(0.5 * RATE / (left.count + 1) as f64);
        let mut suspected: Vec<SuspectedNode> = deleted
            .iter()
            .filter(|one| {
                let row = self.row(one.node, deleted);
                left.residuals[one.node].abs() > quantile * sigma * (1.0 + dot(&row, &row)).sqrt()
            })
            .map(|one| self.named(nodes, one.node, left.residuals[one.node], sigma))
            .collect();
        suspected.sort_by(|a, b| b.off_sigmas.abs().total_cmp(&a.off_sigmas.abs()));
        Outliers { nodes: suspected, coefficients: Vec::new() }
    }

    fn named(&self, nodes: &Nodes, k: usize, residual: f64, sigma: f64) -> SuspectedNode {
        let index = self.sample.posted(k);
        let (u, v) = self.sample.place(k);
        let columns = if let Nodes::Grid(grid) = nodes { Some(grid.v.len()) } else { None };
        let (row, column) = (columns.map(|columns| index / columns), columns.map(|columns| index % columns));
        let place = match nodes {
            Nodes::Grid(_) | Nodes::Scattered(_) => vec![u, v],
            Nodes::Curve(_) => vec![u],
            Nodes::Matrix(_) => Vec::new(),
        };
        let off = residual / self.sample.w(k).sqrt();
        SuspectedNode { index, row, column, place, height: self.sample.z(k), off, off_sigmas: residual / sigma }
    }
}

impl Deleted {
    /// Multiplies a vector by `(I − qqᵀ)^(−1/2)`.
    fn turn(&self, vector: &mut [f64]) {
        let along = self.factor * dot(&self.row, vector);
        vector.iter_mut().zip(&self.row).for_each(|(x, q)| *x += along * q);
    }
}
