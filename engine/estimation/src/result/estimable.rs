//! Sums of coefficients that the nodes determine although the coefficients themselves cannot be
//! separated.

/// A weighted sum of the coefficients of nearly dependent terms ("clustering of regressors"), which
/// the nodes determine well. It is that of least squares, or of the robust estimate.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Include, Model},
/// };
///
/// // Two columns that are nearly one: only the sum of their coefficients is known.
/// let rows: Vec<f64> = (0..12)
///     .map(f64::from)
///     .flat_map(|t| [1.0 + t, 1.0 + t + 0.01 * (t * 1.7).sin()])
///     .collect();
/// let heights =
///     (0..12).map(|t| 5.0 * (1.0 + f64::from(t)) + 0.1 * f64::from(t % 3 - 1)).collect();
/// let nodes = Nodes::matrix(rows, 2, heights, None, None)?;
/// let include = Include { collinearity: true, ..Include::default() };
/// let found = fit(&nodes, &FitSpec { include, ..FitSpec::new(Model::Linear) })?;
/// let sum = &found.estimable.as_ref().expect("asked for")[0];
/// assert!(sum.weights.iter().all(|w| (w - 1.0).abs() < 1e-2));
/// assert!((sum.value - 5.0).abs() < 0.1);
/// assert!(sum.std_error.expect("nodes are left") < 0.05);
/// println!("{}", sum.sentence);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct EstimableSum {
    /// Names of the terms.
    pub terms: Vec<String>,
    /// Weight of each term's coefficient; 1 for the leading one.
    pub weights: Vec<f64>,
    /// The sum.
    pub value: f64,
    /// `None` without an estimate of the noise, and for robust estimates of a weighted matrix.
    pub std_error: Option<f64>,
    /// Student's, at the level of the fit.
    pub interval: Option<[f64; 2]>,
    /// How much worse it is determined than the best of its group, in columns of unit length: 1 to
    /// 30.
    pub condition_index: f64,
    /// The same in words.
    pub sentence: String,
}

impl EstimableSum {
    pub(crate) fn is_finite(&self) -> bool {
        let numbers = [self.value, self.condition_index, self.std_error.unwrap_or(0.0)];
        numbers.iter().chain(&self.weights).chain(self.interval.iter().flatten()).all(|x| x.is_finite())
    }
}
