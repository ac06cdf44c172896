//! L-estimators: linear combinations of order statistics, which regression quantiles take to
//! surfaces.

/// Kind of combination.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Estimator, LEstimator, Model, QuantileWeights, Regularization},
/// };
///
/// // The location of numbers about 10, one of them far off.
/// let heights = vec![9.8, 10.1, 10.4, 9.7, 10.0, 25.0];
/// let nodes = Nodes::matrix(vec![1.0; 6], 1, heights, None, None)?;
/// let value = |combination: LEstimator| {
///     let spec = FitSpec {
///         estimator: Estimator::L(combination),
///         regularization: Regularization::None,
///         ..FitSpec::new(Model::Linear)
///     };
///     Ok::<f64, flankfit_estimation::FitError>(fit(&nodes, &spec)?.coefficients[0].value)
/// };
/// // A fifth of the nodes at either end: the two ends are left out, or moved to their neighbours.
/// let trimmed = value(LEstimator::Trimmed { share: 0.2 })?;
/// assert!((trimmed - (9.8 + 10.0 + 10.1 + 10.4) / 4.0).abs() < 1e-12);
/// let winsorized = value(LEstimator::Winsorized { share: 0.2 })?;
/// assert!((winsorized - (2.0 * 9.8 + 10.0 + 10.1 + 2.0 * 10.4) / 6.0).abs() < 1e-12);
/// // Tukey's trimean.
/// let weights = QuantileWeights::new(&[[0.25, 0.25], [0.5, 0.5], [0.75, 0.25]])
///     .expect("add up to 1");
/// assert!(value(LEstimator::Quantiles(weights))? < 10.3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LEstimator {
    /// Least squares of the nodes between the regression quantiles `share` and 1 − `share`
    /// (Koenker and Bassett 1978; Ruppert and Carroll 1980).
    Trimmed {
        /// Share of the nodes that is left out at either end, between 0 and 1/2.
        share: f64,
    },
    /// Least squares of all nodes, those outside the same two quantiles moved to them (Welsh 1987).
    Winsorized {
        /// Share of the nodes that is moved at either end, between 0 and 1/2.
        share: f64,
    },
    /// A linear combination of regression quantiles.
    Quantiles(QuantileWeights),
}

/// Share of the nodes at either end, unless asked otherwise.
pub const DEFAULT_SHARE: f64 = 0.1;

/// Regression quantiles with weights that add up to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuantileWeights {
    at: [[f64; 2]; QuantileWeights::MOST],
    count: usize,
}

impl QuantileWeights {
    /// Quantiles at most.
    pub const MOST: usize = 9;

    /// Pairs of τ and weight; `None` unless 0 < τ < 1 ascends and the weights add up to 1 within
    /// 1e-9.
    pub fn new(pairs: &[[f64; 2]]) -> Option<Self> {
        let ascends = pairs.windows(2).all(|two| two[0][0] < two[1][0]);
        let inside = pairs.iter().all(|[tau, weight]| *tau > 0.0 && *tau < 1.0 && weight.is_finite());
        let sum: f64 = pairs.iter().map(|pair| pair[1]).sum();
        if pairs.is_empty() || pairs.len() > Self::MOST || !ascends || !inside || (sum - 1.0).abs() > 1e-9 {
            return None;
        }
        let mut at = [[0.0; 2]; Self::MOST];
        at[..pairs.len()].copy_from_slice(pairs);
        Some(QuantileWeights { at, count: pairs.len() })
    }

    /// Pairs of τ and weight, ascending.
    pub fn pairs(&self) -> &[[f64; 2]] {
        &self.at[..self.count]
    }
}
