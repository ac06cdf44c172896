//! The residual checks of a fit as warnings.

use std::borrow::Cow;

use super::conclude::Solved;
use crate::{
    checks::{
        clusters::cluster,
        lack::lack,
        lines::correlation,
        sites::{Seen, Sites},
        variance::uneven,
    },
    data::{Nodes, Sample},
    problem::{Evidence, LinearProblem},
    result::{ResidualWarning, Warning},
    robust::RobustSolution,
    spec::{Along, Correlation, Errors, Variance},
};
use flankfit_numerics::matvec;

/// Residuals this small against the heights are rounding.
const ROUNDING: f64 = 1e-10;

impl Solved<'_> {
    /// Returns a warning for every check that errors with the assumed distribution would seldom
    /// fail.
    pub(super) fn residual_checks(&self) -> impl Iterator<Item = Warning> {
        self.residual_warnings().into_iter().map(Warning::from)
    }

    fn residual_warnings(&self) -> Vec<ResidualWarning> {
        let problem = self.robust.map_or(self.linear, |robust| robust.problem);
        let Evidence::Posted { sample, nodes } = problem.evidence else { return Vec::new() };
        if self.degrees_of_freedom < 2 || !self.spectrum.full_rank() {
            return Vec::new();
        }
        let mut warnings = Vec::new();
        let mut residuals = match self.robust {
            None => weighted_residuals(problem, sample),
            Some(robust) => {
                let (scores, cluster) = scores(robust, sample, nodes);
                warnings.extend(cluster);
                Cow::Owned(scores)
            }
        };
        let size = matvec::dot(&residuals, &residuals).sqrt();
        if !(size > ROUNDING * problem.heights.sqrt()) {
            return warnings;
        }
        let own;
        let make = || Sites::new(problem, sample, nodes);
        let sites = match &problem.factor.separable {
            Some(separable) => separable.axes.checks.sites.get_or_init(make).as_ref(),
            None => {
                own = make();
                own.as_ref()
            }
        };
        if let (Some(sites), true) = (sites, self.robust.is_some()) {
            sites.project(residuals.to_mut());
        }
        warnings.extend(self.correlated(problem, (sample, nodes), &residuals));
        if let Some(sites) = sites {
            warnings.extend(self.of_sites(sites, &sites.seen(&residuals), sample.is_white()));
        }
        warnings
    }

    fn correlated(
        &self,
        problem: &LinearProblem,
        posted: (&Sample, &Nodes),
        residuals: &[f64],
    ) -> Option<ResidualWarning> {
        let found = correlation(problem, posted, self.spec, residuals)?;
        let (correlation, p, factor) = (found.c, found.p, found.strength.factor);
        let along = match (posted.1, &self.spec.errors) {
            (Nodes::Scattered(_), None) => None,
            _ => Some(found.along),
        };
        Some(ResidualWarning::CorrelatedResiduals {
            along,
            model: match &self.spec.errors {
                None => along,
                Some(Errors { along: Along::U | Along::V, correlation: Correlation::Ar1 { .. }, .. }) => {
                    Some(Along::Both).filter(|_| posted.0.count() == posted.1.posted())
                }
                Some(_) => None,
            },
            correlation,
            p,
            factor,
        })
    }

    fn of_sites(&self, sites: &Sites, seen: &Seen, white: bool) -> impl Iterator<Item = ResidualWarning> + use<> {
        // the sandwich assumes nothing about variances
        let constant = self.spec.variance != Variance::Hc3;
        let uneven = constant.then(|| uneven(sites, seen, self.robust.is_some())).flatten();
        let uneven = uneven.map(|found| ResidualWarning::UnevenVariance {
            along: found.along,
            larger: found.larger,
            p: found.p,
            factor: found.factor,
        });
        let lack = lack(sites, seen).map(|found| ResidualWarning::LackOfFit {
            shape: found.shape,
            rms: Some(found.rms).filter(|_| !white),
            p: found.p,
            factor: found.factor,
        });
        uneven.into_iter().chain(lack)
    }
}

/// Residuals of least squares times the roots of the weights.
fn weighted_residuals<'a>(problem: &'a LinearProblem, sample: &Sample) -> Cow<'a, [f64]> {
    if let Some(separable) = &problem.factor.separable {
        return Cow::Borrowed(&separable.residuals);
    }
    let mut residuals = problem.of_image(&problem.factor.qty, true).values.unwrap_or_default();
    if sample.weighted() {
        residuals.iter_mut().enumerate().for_each(|(k, r)| *r *= sample.w(k).sqrt());
    }
    Cow::Owned(residuals)
}

/// Scores of a robust estimate, and the warning of nodes of low weight that lie together.
fn scores(robust: &RobustSolution, sample: &Sample, nodes: &Nodes) -> (Vec<f64>, Option<ResidualWarning>) {
    let RobustSolution { estimate, problem, .. } = robust;
    let working = estimate.factor.working.as_deref().unwrap_or_default();
    let mut residuals = problem.of_working(working, true).values.unwrap_or_default();
    let weights = estimate.report.weights.as_deref().unwrap_or_default();
    let warning = cluster(sample, nodes, weights, &residuals).map(|found| ResidualWarning::ClusteredLowWeights {
        count: found.count,
        share: found.share,
        pairs: found.pairs,
        expected_pairs: found.expected,
        p: found.p,
        place: found.place,
        residual: found.residual,
    });
    residuals.iter_mut().zip(weights).enumerate().for_each(|(k, (r, weight))| *r *= weight * sample.w(k).sqrt());
    (residuals, warning)
}
