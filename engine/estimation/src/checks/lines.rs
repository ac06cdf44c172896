//! Correlation of residuals along scan lines.

use std::sync::OnceLock;

use nalgebra::DMatrix;

use super::{
    LEVEL, SUSPICIOUS,
    serial::{LineBasis, Strength},
    sites::Sites,
};
use crate::{
    data::{Nodes, Sample},
    error_model::lines::{Lines, Measure},
    factor::{Axes, orthonormal_rows},
    problem::LinearProblem,
    spec::{Along, FitSpec},
};
use flankfit_numerics::{
    distribution::{
        normal,
        pearson::{self, Moments},
    },
    matvec,
};

/// From so many nodes on the projection moves c by less than its standard deviation.
const MANY: usize = 5_000;

/// Parts of the checks that a full grid and its model decide.
#[derive(Default)]
pub(crate) struct OfGrid {
    pub sites: OnceLock<Option<Sites>>,
    /// Moments of c along u and along v.
    moments: OnceLock<[Option<Moments>; 2]>,
}

/// Correlation along one family of lines.
pub(crate) struct Correlation {
    pub along: Along,
    /// `Σ rᵢrᵢ₊₁ / Σ r²` over neighbours.
    pub c: f64,
    pub p: f64,
    pub strength: Strength,
}

/// Returns the stronger of the significant correlations along u and v of a grid, that along a
/// curve, or that of neighbouring scattered nodes.
pub(crate) fn correlation(
    problem: &LinearProblem,
    (sample, nodes): (&Sample, &Nodes),
    spec: &FitSpec,
    residuals: &[f64],
) -> Option<Correlation> {
    let rss = matvec::dot(residuals, residuals);
    let courses: &[Along] = match nodes {
        Nodes::Curve(_) => &[Along::Order],
        Nodes::Grid(_) => &[Along::U, Along::V],
        Nodes::Matrix(_) if spec.errors.is_none() => &[],
        Nodes::Scattered(_) | Nodes::Matrix(_) => &[Along::Order],
    };
    let mut rows = None;
    let mut of = |along: Along| match &problem.factor.separable {
        Some(separable) => of_axes(&separable.axes, along, residuals, rss),
        None => {
            let line = spec.errors.as_ref().and_then(|errors| errors.lines.as_deref());
            let lines = match (nodes, &spec.errors) {
                (Nodes::Scattered(_), None) => Lines::winding(sample),
                _ => Lines::new(nodes, sample, along, line, Measure::Steps),
            };
            of_rows(problem, sample, &lines, residuals, rss, &mut rows)
        }
    };
    let found = courses.iter().filter_map(|&along| {
        let (c, p, strength) = of(along)?;
        Some(Correlation { along, c, p, strength })
    });
    found.max_by(|a, b| a.strength.factor.total_cmp(&b.strength.factor))
}

fn of_rows(
    problem: &LinearProblem,
    sample: &Sample,
    lines: &Lines,
    residuals: &[f64],
    rss: f64,
    rows: &mut Option<Vec<f64>>,
) -> Option<(f64, f64, Strength)> {
    let pairs = lines.nodes.windows(2).zip(&lines.steps[1..]).filter(|(_, step)| step.is_finite());
    let c = pairs.map(|(pair, _)| residuals[pair[0]] * residuals[pair[1]]).sum::<f64>() / rss;
    if residuals.len() >= MANY {
        let p = normal::upper_tail(c * residuals.len() as f64 / (lines.pairs() as f64).sqrt());
        return (p < LEVEL).then(|| (c, p, Strength::of_many(c)));
    }
    // a projection makes c less
    if c <= 0.0 {
        return None;
    }
    let n = problem.design.size();
    let rows = rows.get_or_insert_with(|| orthonormal_rows(problem.design, problem.factor, sample));
    let mut q = DMatrix::zeros(n, residuals.len());
    for (mut to, &k) in q.column_iter_mut().zip(&lines.nodes) {
        to.copy_from_slice(&rows[k * n..][..n]);
    }
    let basis = LineBasis::new(q, lines.steps.iter().map(|step| step.is_finite()).collect());
    let (mean, variance) = basis.mean_and_variance()?;
    if c < mean + SUSPICIOUS * variance.sqrt() {
        return None;
    }
    tested(c, &basis.moments()?, || basis)
}

/// The same on a full grid, whose lines are all alike.
fn of_axes(axes: &Axes, along: Along, residuals: &[f64], rss: f64) -> Option<(f64, f64, Strength)> {
    let basis = |along: Along| {
        let (axis, other) = if along == Along::U { (&axes.u, &axes.v) } else { (&axes.v, &axes.u) };
        let (lines, columns) = other.shape();
        LineBasis::of_axis(axis.orthonormal(), lines, columns)
    };
    let width = axes.v.shape().0;
    let sum: f64 = match along {
        Along::U => matvec::dot(&residuals[width..], &residuals[..residuals.len() - width]),
        _ => residuals.chunks_exact(width).map(|row| matvec::dot(&row[1..], &row[..width - 1])).sum(),
    };
    let moments = axes.checks.moments.get_or_init(|| {
        [Along::U, Along::V].map(|along| {
            let basis = basis(along);
            basis.mean_and_variance().and_then(|_| basis.moments())
        })
    });
    let moments = moments[usize::from(along != Along::U)].as_ref()?;
    let c = sum / rss;
    if c < moments.mean + SUSPICIOUS * moments.variance.sqrt() {
        return None;
    }
    tested(c, moments, || basis(along))
}

fn tested(c: f64, moments: &Moments, basis: impl FnOnce() -> LineBasis) -> Option<(f64, f64, Strength)> {
    let p = pearson::upper_tail(c, moments);
    (p < LEVEL).then(|| (c, p, Strength::of(c, &basis())))
}
