//! Confidence intervals of coefficients.

use crate::inference::Inferred;

/// What an interval rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntervalKind {
    /// Student's t about the estimate, which is unbiased.
    Student,
    /// Student's t about least squares, since the regularised estimate has a bias that nothing
    /// limits.
    LeastSquares,
    /// About a filtered estimate whose bias a given norm limit bounds.
    BiasAware,
    /// About the mean of the posterior of nodes and prior, from its standard deviation; where moves
    /// were estimated the one that holds whatever they were, even if the prior is let go.
    Posterior,
}

impl IntervalKind {
    /// As the interface writes it.
    pub fn name(self) -> &'static str {
        match self {
            IntervalKind::Student => "student",
            IntervalKind::LeastSquares => "least_squares",
            IntervalKind::BiasAware => "bias_aware",
            IntervalKind::Posterior => "posterior",
        }
    }
}

impl Interval {
    /// Whether every number is one.
    pub(crate) fn is_finite(&self) -> bool {
        let ends = self.ends.iter().chain(self.least_squares.iter().flatten());
        ends.chain(&self.gain).all(|x| x.is_finite())
    }
}

/// A confidence interval of one coefficient at the level of the spec.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Its ends.
    pub ends: [f64; 2],
    /// What it rests on.
    pub kind: IntervalKind,
    /// What it is made of.
    pub about: Inferred,
    /// Student's interval about least squares, where this one is bias-aware or of a posterior and
    /// least squares has one.
    pub least_squares: Option<[f64; 2]>,
    /// What was gained: its width as a share of that of least squares, where a norm limit or a
    /// prior was given and least squares has one.
    pub gain: Option<f64>,
}
