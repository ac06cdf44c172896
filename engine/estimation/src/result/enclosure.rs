//! Proved intervals of least-squares results.

/// Intervals that contain the exact least-squares results of the posted numbers, each taken as the
/// double that it was read as: `least_squares`, `least_squares_std_error`, `least_squares_rss`.
/// They are proved, whatever rounding did. The functions of a polynomial are exact as well, those
/// of Chebyshev and Legendre on the doubles of `domain`; with filters the heights are those that
/// were left.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Include, Model},
/// };
///
/// // The mean of three heights is 1/3, which no double is.
/// let nodes = Nodes::matrix(vec![1.0; 3], 1, vec![1.0, 0.0, 0.0], None, None)?;
/// let include = Include { enclosure: true, ..Include::default() };
/// let found = fit(&nodes, &FitSpec { include, ..FitSpec::new(Model::Linear) })?;
/// let [low, high] = found.numerics.enclosure.expect("it was asked for").coefficients[0];
/// assert!(3.0 * (low - 1.0 / 3.0) <= 0.0 && low < high && high - low <= f64::EPSILON);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Enclosure {
    /// `[low, high]` of `coefficients[].least_squares`, in order.
    pub coefficients: Vec<[f64; 2]>,
    /// `[low, high]` of `coefficients[].least_squares_std_error`; absent without an estimate of the
    /// noise.
    pub std_errors: Option<Vec<[f64; 2]>>,
    /// `[low, high]` of `residuals.least_squares_rss`.
    #[cfg_attr(feature = "contract", schema(value_type = Vec<f64>, min_items = 2, max_items = 2))]
    pub rss: [f64; 2],
}

/// The reason why there is no [`Enclosure`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "contract", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum NotEnclosed {
    /// Another estimator, other errors, or columns that are not enclosed.
    #[error(
        "numerics.enclosure is left out: results are enclosed of plain and weighted least squares with polynomials or \
         a measurement matrix, at exact positions and with independent errors"
    )]
    OtherFit,
    /// Columns too close to dependent, or numbers too large or too small.
    #[error(
        "numerics.enclosure is left out: the columns are too close to dependent, or numbers too large or too small, \
         for intervals to be proved"
    )]
    NotProved,
}
