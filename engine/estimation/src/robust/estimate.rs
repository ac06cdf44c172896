//! Estimator of a spec, as the least-squares problem that it solves.

use super::{
    few_nodes, l_estimator, least_absolute, likelihood, lp, lts, m_estimator, normal_scores,
    outcome::{Measured, Outcome, Solved, Weighting},
    quantile, rank,
    spread::Spread,
};
use crate::{
    data::Sample,
    diagnostics::dependence,
    error::FitError,
    estimate::PlainEstimate,
    factor::Factor,
    problem::LinearProblem,
    result::{RobustReport, Warning},
    spec::Estimator,
};
use flankfit_numerics::{Dd, triangular};

/// A robust estimate as a fit reports it.
pub(crate) struct RobustSolution<'a> {
    pub estimate: &'a RobustEstimate,
    pub plain: PlainEstimate,
    /// The nodes as posted: the linear problem of the fit has the weights of the problem that was
    /// solved.
    pub posted: &'a Sample<'a>,
    pub problem: &'a LinearProblem<'a>,
    /// Σ of those weights.
    pub weight: f64,
}

impl RobustSolution<'_> {
    /// Σ w r² and max |r| of residuals, with the posted weights.
    pub(crate) fn sums(&self, residuals: &[f64]) -> (f64, f64) {
        let (mut squares, mut largest) = (Dd::ZERO, 0.0f64);
        for (k, r) in residuals.iter().enumerate() {
            squares += Dd::product(self.posted.w(k) * r, *r);
            largest = largest.max(r.abs());
        }
        (squares.to_f64(), largest)
    }
}

/// An estimate as the least-squares problem that it solves.
pub(crate) struct RobustEstimate {
    /// Factor of `√(wω) X` (or `√w X`); `working` is the estimate, `rss` its weighted sum of
    /// squares.
    pub factor: Factor,
    /// wω by posted node; `None` if the node weights are unchanged.
    pub weights: Option<Vec<f64>>,
    /// σ of a height of weight 1 in that problem.
    pub sigma: Option<f64>,
    pub spread: Spread,
    pub report: RobustReport,
    pub warnings: Vec<Warning>,
}

/// Estimates as asked; `None` for least squares, which `measured` already is.
pub(crate) fn estimate(estimator: &Estimator, measured: &Measured) -> Result<Option<RobustEstimate>, FitError> {
    if *estimator == Estimator::LeastSquares {
        return Ok(None);
    }
    if measured.linear.factor.working.is_none() {
        return Err(dependence(measured.linear.design, measured.linear.factor, measured.heights.weight));
    }
    let outcome = match estimator {
        Estimator::LeastSquares => return Ok(None),
        Estimator::M(asked) => m_estimator::estimate(asked, measured)?,
        Estimator::LeastAbsolute => least_absolute::estimate(measured)?,
        Estimator::Lp { p } if *p == 1.0 => least_absolute::estimate(measured)?,
        Estimator::Lp { p } => lp::estimate(*p, measured)?,
        Estimator::Quantile { tau } => quantile::estimate(*tau, measured)?,
        Estimator::LeastTrimmed { coverage, seed } => lts::estimate(*coverage, *seed, measured)?,
        Estimator::Rank => rank::estimate(measured)?,
        Estimator::NormalScores => normal_scores::estimate(measured)?,
        Estimator::L(asked) => l_estimator::estimate(asked, measured)?,
        Estimator::Likelihood(distribution) => likelihood::estimate(*distribution, measured)?,
    };
    let widening = few_nodes::widening(estimator, &outcome, measured);
    Ok(Some(as_least_squares(outcome, widening, measured)))
}

/// Brings an outcome into the form in which a fit goes on, with the factor of its standard errors;
/// `None` for no standard errors.
fn as_least_squares(outcome: Outcome, widening: Option<f64>, measured: &Measured) -> RobustEstimate {
    let Measured { linear, sample, .. } = *measured;
    let (m, n) = (sample.count(), linear.design.size());
    let mut warnings = outcome.warnings;
    if widening.is_none() && m > n && outcome.scale.is_some_and(|scale| scale > 0.0) {
        warnings.push(Warning::FewNodesOfRobust { nodes: m, coefficients: n });
    }
    let plain = linear.factor;
    let (mut factor, weights, omega) = match outcome.solved {
        Solved::Weighted(Weighting { factor, omega }) => (*factor, Some(measured.posted_weights(&omega)), Some(omega)),
        Solved::Step(step) => {
            let mut working: Vec<Dd> = step.into_iter().map(Dd::from).collect();
            triangular::solve_upper(&plain.r, &mut working);
            for (c, least_squares) in working.iter_mut().zip(plain.working.iter().flatten()) {
                *c += *least_squares;
            }
            (plain.with_working(working), None, None)
        }
        Solved::Working(working) => (plain.with_working(working), None, None),
    };
    if weights.is_none() {
        let summary = linear.of_working(factor.working.as_deref().unwrap_or(&[]), false);
        (factor.rss, factor.max_abs) = (summary.rss, summary.max_abs);
    }
    let spread = Spread::new(&factor, plain, outcome.dispersion, outcome.along, weights.is_some());
    let rejected: Vec<usize> = omega.map_or_else(Vec::new, |omega| {
        omega.iter().enumerate().filter(|(_, w)| **w == 0.0).map(|(k, _)| sample.posted(k)).collect()
    });
    let report = RobustReport {
        converged: outcome.converged,
        iterations: outcome.iterations,
        tolerance_reached: outcome.tolerance_reached,
        scale: outcome.scale,
        dispersion: outcome.dispersion.zip(widening).map(|(tau, factor)| factor * tau),
        objective: outcome.objective,
        weights: Some(outcome.weights),
        rejected_count: rejected.len(),
        rejected: Some(rejected),
        certificate: outcome.certificate,
        unique: outcome.unique,
        vertex: outcome.vertex.map(|nodes| nodes.into_iter().map(|k| sample.posted(k)).collect()),
        subset_size: outcome.subset_size,
        start: outcome.start,
        solution: outcome.local,
        minimax: outcome.minimax,
        likelihood: outcome.likelihood,
        coefficients: Vec::new(),
    };
    let sigma = spread.sigma();
    RobustEstimate { sigma, factor, weights, spread: spread.widened(widening), report, warnings }
}
