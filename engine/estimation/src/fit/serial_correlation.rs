//! The warning that residuals of plain least squares are correlated along scan lines.

use nalgebra::DMatrix;

use super::conclude::Solved;
use crate::{
    data::{Nodes, Sample},
    error_model::{
        lines::{Lines, Measure},
        serial::{LineBasis, Strength},
    },
    factor::{Separable, orthonormal_rows},
    problem::Evidence,
    result::Warning,
    spec::Along,
};
use flankfit_numerics::distribution::{normal, pearson};

/// Rate of false alarms.
const LEVEL: f64 = 1e-3;
/// Standard deviations above the mean from which on a tail can be so small.
const SUSPICIOUS: f64 = 2.5;
/// Residuals this small against the heights are rounding.
const ROUNDING: f64 = 1e-10;
/// From so many nodes on the projection moves c by less than its standard deviation.
const MANY: usize = 5_000;

/// Correlation along one family of lines.
struct Correlation {
    c: f64,
    p: f64,
    strength: Strength,
}

impl Solved<'_> {
    /// Warning, if c along u or v (of a grid), or along the abscissae of a curve, exceeds what
    /// white noise would cause.
    pub(super) fn correlated_residuals(&self) -> Option<Warning> {
        let Evidence::Posted { sample, nodes } = self.linear.evidence else { return None };
        let rss = self.least_squares.rss;
        let noise = rss.sqrt() > ROUNDING * self.heights.about_zero.sqrt();
        if self.robust.is_some()
            || self.spec.errors.is_some()
            || !noise
            || self.degrees_of_freedom < 2
            || !self.spectrum.full_rank()
        {
            return None;
        }
        let courses: &[Along] = match nodes {
            Nodes::Curve(_) => &[Along::Order],
            Nodes::Grid(_) => &[Along::U, Along::V],
            Nodes::Scattered(_) | Nodes::Matrix(_) => &[],
        };
        let level = LEVEL / courses.len().max(1) as f64;
        let found = match &self.linear.factor.separable {
            Some(separable) => courses.iter().map(|&along| (along, of_axes(separable, along, rss, level))).collect(),
            None => self.of_rows(sample, nodes, courses, rss, level),
        };
        let strongest = found
            .into_iter()
            .filter_map(|(along, found)| Some((along, found?)))
            .max_by(|(_, a), (_, b)| a.strength.factor.total_cmp(&b.strength.factor));
        strongest.map(|(along, Correlation { c, p, strength })| Warning::CorrelatedResiduals {
            along,
            correlation: c,
            p,
            factor: strength.factor,
        })
    }

    fn of_rows(
        &self,
        sample: &Sample,
        nodes: &Nodes,
        courses: &[Along],
        rss: f64,
        level: f64,
    ) -> Vec<(Along, Option<Correlation>)> {
        if courses.is_empty() {
            return Vec::new();
        }
        let mut residuals = self.linear.of_working(&self.least_squares.working, true).values.unwrap_or_default();
        for (k, r) in residuals.iter_mut().enumerate() {
            *r *= sample.w(k).sqrt();
        }
        let mut rows: Option<Vec<f64>> = None;
        let n = self.linear.design.size();
        let mut of = |along: Along| {
            let lines = Lines::new(nodes, sample, along, None, Measure::Steps);
            let pairs = lines.nodes.windows(2).zip(&lines.steps[1..]).filter(|(_, step)| step.is_finite());
            let c = pairs.map(|(pair, _)| residuals[pair[0]] * residuals[pair[1]]).sum::<f64>() / rss;
            if residuals.len() >= MANY {
                let p = normal::upper_tail(c * residuals.len() as f64 / (lines.pairs() as f64).sqrt());
                return (p < level).then(|| Correlation { c, p, strength: Strength::of_many(c) });
            }
            // what projections do to c is to make it less
            if c <= 0.0 {
                return None;
            }
            let rows = rows.get_or_insert_with(|| orthonormal_rows(self.linear.design, self.linear.factor, sample));
            let mut q = DMatrix::zeros(n, residuals.len());
            for (mut to, &k) in q.column_iter_mut().zip(&lines.nodes) {
                to.copy_from_slice(&rows[k * n..][..n]);
            }
            let linked = lines.steps.iter().map(|step| step.is_finite()).collect();
            tested(c, &LineBasis::new(q, linked), level)
        };
        courses.iter().map(|&along| (along, of(along))).collect()
    }
}

/// On a full grid, whose lines are all alike.
fn of_axes(separable: &Separable, along: Along, rss: f64, level: f64) -> Option<Correlation> {
    let axes = &separable.axes;
    let (axis, other, sum) = match along {
        Along::U => (&axes.u, &axes.v, separable.neighbours[0]),
        Along::V | Along::Order => (&axes.v, &axes.u, separable.neighbours[1]),
    };
    let c = sum / rss;
    if c <= 0.0 {
        return None;
    }
    let (lines, columns) = other.shape();
    tested(c, &LineBasis::of_axis(axis.orthonormal(), lines, columns), level)
}

fn tested(c: f64, basis: &LineBasis, level: f64) -> Option<Correlation> {
    let (mean, variance) = basis.mean_and_variance()?;
    if c < mean + SUSPICIOUS * variance.sqrt() {
        return None;
    }
    let p = pearson::upper_tail(c, &basis.moments()?);
    (p < level).then(|| Correlation { c, p, strength: Strength::of(c, basis) })
}
