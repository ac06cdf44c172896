//! Confidence intervals of coefficients.

use crate::inference::Inferred;

/// Basis of an interval. `student`: Student's t about the estimate. `least_squares`: Student's
/// t about the unregularised estimate (least squares, or the robust estimate), where the bias
/// of the regularised one is unbounded. (With `noise_sigma`, t is the normal quantile in all of
/// these.) `bias_aware`: the shortest interval about a filtered estimate that holds for all
/// coefficients within the given norm limit, and for no others. `posterior`: Student's t about
/// the mean of the posterior, if the prior is given; if moves are estimated, an interval that
/// is shorter where the earlier iterations predict well. With a known σ its coverage holds for
/// any flank, and it is the same after a prior is dropped (docs/explanation/prior.md).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum IntervalKind {
    /// Student's t about the estimate, which is unbiased.
    Student,
    /// Student's t about least squares, since the regularised estimate has a bias that nothing
    /// limits.
    LeastSquares,
    /// About a filtered estimate whose bias a given norm limit bounds.
    BiasAware,
    /// About the mean of the posterior of nodes and prior, from its standard deviation; if moves
    /// were estimated the one that holds whatever they were, even if the prior is dropped.
    Posterior,
}

impl IntervalKind {}

impl Interval {
    /// True if every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        let ends = self.ends.iter().chain(self.least_squares.iter().flatten());
        ends.chain(&self.gain).all(|x| x.is_finite())
    }
}

/// A confidence interval of one coefficient at the level of the spec.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Interval {
    /// Confidence interval of the true coefficient at `level`, `[low, high]`. Coverage at 0.95 is
    /// 0.94 to 0.96 on average for independent normal errors (docs/explanation/intervals.md); for
    /// other cases see docs/explanation/errors.md, docs/explanation/prior.md and
    /// docs/explanation/selection.md. The regularised `value` may lie outside. Absent without an
    /// estimate of the noise, and where the coefficient is not bounded.
    #[cfg_attr(feature = "contract", serde(rename = "interval"))]
    pub ends: [f64; 2],
    /// Basis of the interval.
    #[cfg_attr(feature = "contract", serde(rename = "interval_kind"))]
    pub kind: IntervalKind,
    /// Estimate and standard error that it is made of.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub about: Inferred,
    /// Student's interval about `least_squares` by these nodes alone; there with an `interval`
    /// of kind `bias_aware` or `posterior`.
    #[cfg_attr(feature = "contract", serde(rename = "least_squares_interval"))]
    pub least_squares: Option<[f64; 2]>,
    /// Effect of the given norm limit (`coefficient_norm_limit`) or `prior`: the width of
    /// `interval` divided by that of Student's interval about least squares, above 0. 0.6 is an
    /// interval shorter by 40 %; 1 is no gain, and above 1 the prior made it wider.
    #[cfg_attr(feature = "contract", serde(rename = "interval_gain"))]
    pub gain: Option<f64>,
}
