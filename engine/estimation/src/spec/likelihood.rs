//! Maximum likelihood where errors are not normal.

/// The distribution of errors. A shape that is not given is estimated together with coefficients
/// and scale.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Distribution, Estimator, Model, Regularization},
/// };
///
/// // The location of numbers about 10, one of them far off.
/// let heights = vec![9.8, 10.1, 10.4, 9.7, 10.0, 25.0];
/// let nodes = Nodes::matrix(vec![1.0; 6], 1, heights, None, None)?;
/// let spec = FitSpec {
///     estimator: Estimator::Likelihood(Distribution::Student { freedom: Some(2.0) }),
///     regularization: Regularization::None,
///     ..FitSpec::new(Model::Linear)
/// };
/// let found = fit(&nodes, &spec)?;
/// assert!((found.coefficients[0].value - 10.0).abs() < 0.1);
/// let likelihood = found.robust.and_then(|report| report.likelihood).expect("was asked for");
/// assert_eq!(likelihood.shape, Some(2.0));
/// assert!(likelihood.log_likelihood < 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distribution {
    /// Student's t with scale s: density ∝ (1 + u²/ν)^(−(ν+1)/2), u = r/s.
    Student {
        /// ν.
        freedom: Option<f64>,
    },
    /// Density exp(−|r|/b)/(2b): least absolute deviations.
    Laplace,
    /// Generalised normal (exponential power, Subbotin): density ∝ exp(−(|r|/a)^p).
    GeneralizedNormal {
        /// p: 1 is Laplace's, 2 the normal distribution.
        exponent: Option<f64>,
    },
}

impl Distribution {
    /// ν that can be given or found.
    pub const FREEDOM: [f64; 2] = [0.5, 200.0];
    /// p that can be given or found.
    pub const EXPONENT: [f64; 2] = [1.0, 8.0];
}
