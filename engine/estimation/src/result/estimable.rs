//! Sums of coefficients that the nodes determine although the coefficients themselves cannot be
//! separated.

/// A sum of the coefficients of nearly dependent terms that the nodes determine, of the
/// unregularised estimate.
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
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct EstimableSum {
    /// The terms whose coefficients cannot be separated.
    pub terms: Vec<String>,
    /// Weight of the coefficient of each of `terms`; 1 for the leading one.
    pub weights: Vec<f64>,
    /// Σ weight · coefficient, found without the large coefficients that cancel in it; in the
    /// unit of the leading coefficient.
    pub value: f64,
    /// Standard error of `value`. Absent without an estimate of the noise, and for estimators
    /// that weight the matrix.
    pub std_error: Option<f64>,
    /// Student's confidence interval at `level`, `[low, high]`.
    #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
    pub interval: Option<[f64; 2]>,
    /// Ratio of the standard error of the sum to that of the best determined sum of the same
    /// terms, in columns of unit length: 1 to 30.
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
