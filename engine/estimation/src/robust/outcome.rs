//! Input and result of a robust estimator.

use crate::{
    data::{Heights, Sample},
    factor::Factor,
    problem::LinearProblem,
    result::{LikelihoodReport, LocalSolution, MinimaxReport, Warning},
    spec::Start,
};
use flankfit_numerics::Dd;

/// Nodes with their least-squares factor.
#[derive(Clone, Copy)]
pub(crate) struct Measured<'a> {
    pub linear: &'a LinearProblem<'a>,
    pub sample: &'a Sample<'a>,
    pub heights: &'a Heights,
}

impl Measured<'_> {
    /// Node weights times ω, by posted node; ω is by counted node.
    pub(crate) fn posted_weights(&self, omega: &[f64]) -> Vec<f64> {
        let posted =
            self.sample.index().and_then(|index| index.last()).map_or(self.sample.count(), |k| *k as usize + 1);
        let mut weights = vec![0.0; posted];
        for (k, omega) in omega.iter().enumerate() {
            weights[self.sample.posted(k)] = self.sample.w(k) * omega;
        }
        weights
    }
}

/// Result of an estimator.
pub(super) struct Outcome {
    pub solved: Solved,
    pub converged: bool,
    pub iterations: usize,
    pub tolerance_reached: Option<f64>,
    pub scale: Option<f64>,
    pub objective: f64,
    pub weights: Vec<f64>,
    pub certificate: Option<f64>,
    pub unique: Option<bool>,
    pub vertex: Option<Vec<usize>>,
    pub subset_size: Option<usize>,
    pub start: Option<Start>,
    pub local: LocalSolution,
    /// τ of the standard errors.
    pub dispersion: Option<f64>,
    /// Slopes of ψ at the residuals, of estimators that have a ψ.
    pub slopes: Option<Slopes>,
    /// Another τ along one direction.
    pub along: Option<Along>,
    pub minimax: Option<MinimaxReport>,
    pub likelihood: Option<LikelihoodReport>,
    pub warnings: Vec<Warning>,
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
            slopes: None,
            along: None,
            minimax: None,
            likelihood: None,
            warnings: Vec::new(),
        }
    }
}

/// Slopes of ψ at the residuals.
#[derive(Clone, Copy)]
pub(super) struct Slopes {
    /// Their mean.
    pub mean: f64,
    /// Huber's K, which τ contains.
    pub k: f64,
}

impl Slopes {
    /// Returns those of m residuals of a model of n coefficients.
    pub(super) fn new(slopes: impl Iterator<Item = f64> + Clone, m: usize, n: usize) -> Self {
        let count = m as f64;
        let mean = slopes.clone().sum::<f64>() / count;
        let variance = slopes.map(|slope| (slope - mean).powi(2)).sum::<f64>() / count;
        Slopes { mean, k: 1.0 + n as f64 / count * variance / (mean * mean) }
    }
}

/// The form in which the estimate came.
pub(super) enum Solved {
    /// Weights, and the factor with them.
    Weighted(Weighting),
    /// A step from least squares, in Q's coordinates.
    Step(Vec<f64>),
    /// Coefficients in the working basis.
    Working(Vec<Dd>),
}

pub(super) struct Weighting {
    pub factor: Box<Factor>,
    /// Factors by counted node.
    pub omega: Vec<f64>,
}

/// A direction in Q's coordinates along which the standard deviation is another one.
pub(crate) struct Along {
    pub direction: Vec<f64>,
    pub dispersion: f64,
}
