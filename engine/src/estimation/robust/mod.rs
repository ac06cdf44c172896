//! Estimators that gross errors cannot pull away, and how they join the way of a fit.
//!
//! Every estimator ends as a least-squares problem whose solution is the estimate, so that
//! spectrum, λ*, bias bounds and collinearity go on from there as for any fit:
//! * M-estimators and least trimmed squares end in weights ω: the problem is that of `√(wω) X`, and
//!   all diagnostics refer to this weighted matrix;
//! * least absolute deviations, quantiles, Lp and rank dispersion end in coefficients Â: the matrix
//!   stays `√w X`, the heights become `√w X Â`, and the filter acts on `aᵢ = Vᵢᵀ Â` (Eq. 29).
//!
//! Standard errors are asymptotic: covariance `τ² (XᵀX)⁻¹` of the unregularised estimate, each
//! estimator saying its τ, and carried through the filter for the regularised one. The same τ is
//! the σ of the criteria for λ* (times the mean of ω where the matrix is weighted), unless the
//! caller gives one.
//!
//! Everything is a fixed sequence of operations: random subsets come from a seed, and every
//! iteration has an end.

mod exact;
mod least_absolute;
pub mod loss;
mod lp;
mod lts;
mod m_estimator;
mod normal;
mod quantile;
mod random;
mod rank;
mod rows;
mod scale;
mod spread;
mod vertex;

use super::{
    admission,
    error::FitError,
    estimate::Beside,
    estimator::{Estimator, Start},
    factor::{Factor, multiply_upper_vector},
    residuals::{Heights, Place},
    result::{LocalSolution, RobustReport, Warning},
    sample::Sample,
};
use crate::numerics::{Dd, triangular};

use spread::Spread;

/// Nodes with their least-squares factor.
#[derive(Clone, Copy)]
pub(super) struct Measured<'a> {
    pub place: &'a Place<'a>,
    pub sample: &'a Sample<'a>,
    pub heights: &'a Heights,
}

/// A robust estimate as a fit reports it.
pub(super) struct Joined<'a> {
    pub robust: &'a Robust,
    pub beside: Beside,
    /// The nodes as posted: the place of the fit has the weights of the problem that was solved.
    pub posted: &'a Sample<'a>,
    /// Σ of those weights.
    pub weight: f64,
}

impl Measured<'_> {
    /// Node weights times ω, by posted node; ω is by counted node.
    fn posted_weights(&self, omega: &[f64]) -> Vec<f64> {
        let posted =
            self.sample.index().and_then(|index| index.last()).map_or(self.sample.count(), |k| *k as usize + 1);
        let mut weights = vec![0.0; posted];
        for (k, omega) in omega.iter().enumerate() {
            weights[self.sample.posted(k)] = self.sample.w(k) * omega;
        }
        weights
    }
}

/// What an estimator found.
struct Outcome {
    solved: Solved,
    converged: bool,
    iterations: usize,
    tolerance_reached: Option<f64>,
    scale: Option<f64>,
    objective: f64,
    weights: Vec<f64>,
    certificate: Option<f64>,
    unique: Option<bool>,
    vertex: Option<Vec<usize>>,
    subset_size: Option<usize>,
    start: Option<Start>,
    local: LocalSolution,
    /// τ of the standard errors.
    dispersion: Option<f64>,
    /// Another τ along one direction.
    along: Option<Along>,
    warnings: Vec<Warning>,
}

impl Default for Outcome {
    fn default() -> Self {
        Outcome {
            solved: Solved::Step(Vec::new()),
            converged: true,
            iterations: 0,
            tolerance_reached: None,
            scale: None,
            objective: 0.0,
            weights: Vec::new(),
            certificate: None,
            unique: None,
            vertex: None,
            subset_size: None,
            start: None,
            local: LocalSolution::Global,
            dispersion: None,
            along: None,
            warnings: Vec::new(),
        }
    }
}

/// The form in which the estimate came.
enum Solved {
    /// Weights, and the factor with them.
    Weighted(Weighting),
    /// A step from least squares, in Q's coordinates.
    Step(Vec<f64>),
    /// Coefficients in the working basis.
    Working(Vec<Dd>),
}

struct Weighting {
    factor: Box<Factor>,
    /// By counted node.
    omega: Vec<f64>,
}

/// A direction in Q's coordinates along which the standard deviation is another one.
pub(super) struct Along {
    pub direction: Vec<f64>,
    pub dispersion: f64,
}

impl Joined<'_> {
    /// Σ w r² and max |r| of residuals, with the posted weights.
    pub fn sums(&self, residuals: &[f64]) -> (f64, f64) {
        let (mut squares, mut largest) = (Dd::ZERO, 0.0f64);
        for (k, r) in residuals.iter().enumerate() {
            squares += Dd::product(self.posted.w(k) * r, *r);
            largest = largest.max(r.abs());
        }
        (squares.to_f64(), largest)
    }
}

/// An estimate as the least-squares problem that it solves.
pub(super) struct Robust {
    /// Of `√(wω) X` (or `√w X`); `working` is the estimate, `rss` its weighted sum of squares.
    pub factor: Factor,
    /// wω by posted node; `None` where node weights stand.
    pub weights: Option<Vec<f64>>,
    /// σ of a height of weight 1 in that problem.
    pub sigma: Option<f64>,
    pub spread: Spread,
    pub report: RobustReport,
    pub warnings: Vec<Warning>,
}

/// Estimates as asked; `None` for least squares, which `measured` already is.
pub(super) fn estimate(estimator: &Estimator, measured: &Measured) -> Result<Option<Robust>, FitError> {
    if *estimator == Estimator::LeastSquares {
        return Ok(None);
    }
    if measured.place.factor.working.is_none() {
        return Err(admission::dependence(measured.place.design, measured.place.factor, measured.heights.weight));
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
    };
    Ok(Some(joined(outcome, measured)))
}

/// Brings an outcome into the form in which a fit goes on.
fn joined(outcome: Outcome, measured: &Measured) -> Robust {
    let Measured { place, sample, .. } = *measured;
    let plain = place.factor;
    let (mut factor, weights, omega) = match outcome.solved {
        Solved::Weighted(Weighting { factor, omega }) => (*factor, Some(measured.posted_weights(&omega)), Some(omega)),
        Solved::Step(step) => {
            let mut working: Vec<Dd> = step.into_iter().map(Dd::from).collect();
            triangular::solve_upper(&plain.r, &mut working);
            for (c, least_squares) in working.iter_mut().zip(plain.working.iter().flatten()) {
                *c += *least_squares;
            }
            (with_working(plain, working), None, None)
        }
        Solved::Working(working) => (with_working(plain, working), None, None),
    };
    if weights.is_none() {
        let seen = place.of_working(factor.working.as_deref().unwrap_or(&[]), false);
        (factor.rss, factor.max_abs) = (seen.rss, seen.max_abs);
    }
    let spread = Spread::new(&factor, plain, outcome.dispersion, outcome.along, weights.is_some());
    let rejected = omega.map_or_else(Vec::new, |omega| {
        omega.iter().enumerate().filter(|(_, w)| **w == 0.0).map(|(k, _)| sample.posted(k)).collect()
    });
    let report = RobustReport {
        converged: outcome.converged,
        iterations: outcome.iterations,
        tolerance_reached: outcome.tolerance_reached,
        scale: outcome.scale,
        dispersion: outcome.dispersion,
        objective: outcome.objective,
        weights: outcome.weights,
        rejected,
        certificate: outcome.certificate,
        unique: outcome.unique,
        vertex: outcome.vertex.map(|nodes| nodes.into_iter().map(|k| sample.posted(k)).collect()),
        subset_size: outcome.subset_size,
        start: outcome.start,
        solution: outcome.local,
        coefficients: Vec::new(),
    };
    Robust { sigma: spread.sigma(), factor, weights, spread, report, warnings: outcome.warnings }
}

/// The plain factor with other coefficients.
fn with_working(plain: &Factor, working: Vec<Dd>) -> Factor {
    let mut qty = working.clone();
    multiply_upper_vector(&plain.r, &mut qty);
    Factor {
        r: plain.r.clone(),
        change: plain.change.clone(),
        qty,
        working: Some(working),
        ones: plain.ones.clone(),
        arithmetic: plain.arithmetic,
        relative_error: plain.relative_error,
        rss: plain.rss,
        max_abs: plain.max_abs,
        separable: None,
        rounded: plain.rounded,
    }
}
