//! Result of a model of the errors.

use crate::spec::{Along, Correlation, Matern};

/// Correlations of the errors along scan lines. `rss` and `sigma` of `residuals` are then those of
/// the whitened rows, where sigma is the standard deviation of a height of weight 1; the other
/// residual figures are those of the heights.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = ErrorsResult)
)]
pub struct ErrorsReport {
    /// Correlation of the errors.
    #[cfg_attr(feature = "contract", serde(rename = "type"))]
    pub kind: CorrelationKind,
    /// Direction of the lines.
    pub along: Along,
    /// Parameters of the correlation.
    pub parameters: ErrorParameters,
    /// Number of independent heights that would determine a mean equally well.
    pub effective_count: f64,
    /// Durbin and Watson's d: the mean of (rᵢ − rᵢ₊₁)² over neighbours on one line divided by the
    /// mean of r² over the nodes, about 2 for white residuals and any number of lines. Given for
    /// plain least squares and for the whitened rows. Absent where no line has two nodes.
    #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
    pub durbin_watson: Option<[f64; 2]>,
    /// Ljung and Box's Q of both: m(m + 2) Σ cₕ²/mₕ over the lags, cₕ being Σ rᵢrᵢ₊ₕ / Σ r² over
    /// the mₕ pairs that lie h nodes apart on one line.
    #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
    pub ljung_box: Option<[f64; 2]>,
    /// P(χ² > Q) with as many degrees of freedom as lags.
    #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
    pub ljung_box_p: Option<[f64; 2]>,
    /// Lags that Q is summed over: up to ten, or a fifth of the nodes, as far as lines have pairs
    /// for a fifth of the nodes. 0 where no line has two nodes.
    pub ljung_box_lags: usize,
}

/// Correlation of the errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = CorrelationName)
)]
pub enum CorrelationKind {
    /// Autoregression of first order.
    Ar1,
    /// Autoregression of second order.
    Ar2,
    /// Matérn's correlation.
    Matern,
}

/// Parameters of the correlation, given or estimated: `rho`, `phi`, or `length` and `nugget`.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct ErrorParameters {
    /// For `ar1`: the correlation of neighbours. At 0.95 over a line of 60 nodes, 95 % intervals
    /// have a coverage of 0.92 only, 0.88 for the worst coefficient (docs/explanation/errors.md).
    pub rho: Option<f64>,
    /// Along `both` axes: the correlation of neighbours along v; `rho` is that along u.
    pub rho_v: Option<f64>,
    /// For `ar2`: φ₁ and φ₂.
    #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
    pub phi: Option<[f64; 2]>,
    /// For `matern`: the correlation length in the unit of the abscissae.
    pub length: Option<f64>,
    /// For `matern`: share of white noise in the variance.
    pub nugget: Option<f64>,
    /// Standard error of `rho` or `length`, where it was estimated.
    pub std_error: Option<f64>,
    /// Standard error of `rho_v`, where it was estimated.
    pub rho_v_std_error: Option<f64>,
    /// Standard errors of `phi`, where they were estimated.
    #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
    pub phi_std_error: Option<[f64; 2]>,
    /// Standard error of `nugget`, where it was estimated.
    pub nugget_std_error: Option<f64>,
}

/// Variances that were estimated.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = VarianceResult)
)]
pub struct VarianceReport {
    /// For `groups`, by their names.
    pub groups: Option<Vec<GroupSigma>>,
    /// For `power_of`: the exponent.
    pub exponent: Option<f64>,
    /// Coordinate at which the standard deviation of a height of weight 1 is `residuals.sigma`: the
    /// geometric mean of the coordinate.
    pub at: Option<f64>,
}

/// The standard deviation of a height of weight 1 of a group.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct GroupSigma {
    /// Name of the group in the request.
    pub group: i64,
    /// In the unit of the heights.
    pub sigma: f64,
}

/// Both figures of residuals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whiteness {
    /// The mean of `(rᵢ − rᵢ₊₁)²` over neighbours on one line over the mean of r² over the nodes:
    /// about 2 for white residuals, whatever the number of lines.
    pub durbin_watson: f64,
    /// `m(m + 2) Σ cₕ²/mₕ` over lags h, cₕ being `Σ rᵢrᵢ₊ₕ/Σ r²` over the mₕ pairs of lag h.
    pub ljung_box: f64,
    /// P(χ² > Q) of as many degrees of freedom as lags.
    pub ljung_box_p: f64,
}

impl ErrorsReport {
    /// Creates the report from the correlation, the standard errors of its estimated parameters,
    /// and the whiteness of plain and whitened residuals (`None` where all are 0 but for rounding,
    /// or no line has two nodes).
    pub(crate) fn new(
        correlation: Correlation,
        along: Along,
        rho_v: Option<f64>,
        std_errors: Option<[f64; 2]>,
        effective_count: f64,
        whiteness: Option<[Whiteness; 2]>,
        lags: usize,
    ) -> Self {
        let std_error = std_errors.map(|[first, _]| first);
        let none = ErrorParameters::default();
        let (kind, parameters) = match correlation {
            Correlation::Ar1 { rho } => {
                let rho_v_std_error = rho_v.and(std_errors).map(|[_, second]| second);
                (CorrelationKind::Ar1, ErrorParameters { rho, std_error, rho_v, rho_v_std_error, ..none })
            }
            Correlation::Ar2 { phi } => {
                (CorrelationKind::Ar2, ErrorParameters { phi, phi_std_error: std_errors, ..none })
            }
            Correlation::Matern { parameters } => {
                let (length, nugget) = parameters.map(|Matern { length, nugget }| (length, nugget)).unzip();
                let nugget_std_error = std_errors.map(|[_, second]| second);
                (CorrelationKind::Matern, ErrorParameters { length, nugget, std_error, nugget_std_error, ..none })
            }
        };
        ErrorsReport {
            kind,
            along,
            parameters,
            effective_count,
            durbin_watson: whiteness.map(|both| both.map(|found| found.durbin_watson)),
            ljung_box: whiteness.map(|both| both.map(|found| found.ljung_box)),
            ljung_box_p: whiteness.map(|both| both.map(|found| found.ljung_box_p)),
            ljung_box_lags: lags,
        }
    }

    pub(crate) fn is_finite(&self) -> bool {
        let ErrorParameters { phi_std_error, std_error, rho_v_std_error, nugget_std_error, .. } = &self.parameters;
        let pairs = [phi_std_error, &self.durbin_watson, &self.ljung_box, &self.ljung_box_p];
        let numbers = [std_error, rho_v_std_error, nugget_std_error].into_iter().flatten();
        numbers.chain(pairs.into_iter().flatten().flatten()).chain([&self.effective_count]).all(|x| x.is_finite())
    }
}

impl VarianceReport {
    pub(crate) fn is_finite(&self) -> bool {
        let groups = self.groups.iter().flatten().map(|group| group.sigma);
        groups.chain(self.exponent).chain(self.at).all(f64::is_finite)
    }
}
