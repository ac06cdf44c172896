//! What was found of errors that are not white, as it is answered.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use flankfit_engine::estimation::{
    result::{ErrorsReport, PositionsReport, VarianceReport, Whiteness},
    spec::{Along, Correlation, Matern, PositionKind},
};

/// Correlations of the errors along scan lines. `rss` and `sigma` of `residuals` are then those of
/// the whitened rows, where sigma is the standard deviation of a height of weight 1; the other
/// residual figures are those of the heights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ErrorsResult)]
pub struct ErrorsResult {
    #[serde(rename = "type")]
    pub kind: CorrelationName,
    pub along: Along,
    pub parameters: ErrorParameters,
    /// Number of independent heights that would determine a mean equally well.
    pub effective_count: f64,
    /// Durbin and Watson's d: the mean of (rᵢ − rᵢ₊₁)² over neighbours on one line divided by the
    /// mean of r² over the nodes, about 2 for white residuals and any number of lines. Given for
    /// plain least squares and for the whitened rows. Absent where no line has two nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 2, max_items = 2)]
    pub durbin_watson: Option<[f64; 2]>,
    /// Ljung and Box's Q of both: m(m + 2) Σ cₕ²/mₕ over the lags, cₕ being Σ rᵢrᵢ₊ₕ / Σ r² over
    /// the mₕ pairs that lie h nodes apart on one line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 2, max_items = 2)]
    pub ljung_box: Option<[f64; 2]>,
    /// P(χ² > Q) with as many degrees of freedom as lags.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 2, max_items = 2)]
    pub ljung_box_p: Option<[f64; 2]>,
    /// Lags that Q is summed over: up to ten, or a fifth of the nodes, as far as lines have pairs
    /// for a fifth of the nodes. 0 where no line has two nodes.
    pub ljung_box_lags: usize,
}

/// Correlation of the errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum CorrelationName {
    Ar1,
    Ar2,
    Matern,
}

/// Parameters of the correlation, given or estimated: `rho`, `phi`, or `length` and `nugget`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ErrorParameters)]
pub struct ErrorParameters {
    /// For `ar1`: the correlation of neighbours. At 0.95 over a line of 60 nodes, 95 % intervals
    /// have a coverage of 0.92 only, 0.88 for the worst coefficient (docs/explanation/errors.md).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rho: Option<f64>,
    /// For `ar2`: φ₁ and φ₂.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 2, max_items = 2)]
    pub phi: Option<[f64; 2]>,
    /// For `matern`: the correlation length in the unit of the abscissae.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// For `matern`: share of white noise in the variance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nugget: Option<f64>,
    /// Standard error of `rho` or `length`, where it was estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_error: Option<f64>,
    /// Standard errors of `phi`, where they were estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 2, max_items = 2)]
    pub phi_std_error: Option<[f64; 2]>,
    /// Standard error of `nugget`, where it was estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nugget_std_error: Option<f64>,
}

impl From<&ErrorsReport> for ErrorsResult {
    fn from(report: &ErrorsReport) -> Self {
        let ErrorsReport { correlation, along, std_errors, effective_count, whiteness, lags } = report;
        let std_error = |k: usize| std_errors.map(|errors| errors[k]);
        let (kind, parameters) = match *correlation {
            Correlation::Ar1 { rho } => {
                (CorrelationName::Ar1, ErrorParameters { rho, std_error: std_error(0), ..ErrorParameters::default() })
            }
            Correlation::Ar2 { phi } => (
                CorrelationName::Ar2,
                ErrorParameters { phi, phi_std_error: *std_errors, ..ErrorParameters::default() },
            ),
            Correlation::Matern { parameters } => {
                let (length, nugget) = parameters.map(|Matern { length, nugget }| (length, nugget)).unzip();
                let parameters = ErrorParameters {
                    length,
                    nugget,
                    std_error: std_error(0),
                    nugget_std_error: std_error(1),
                    ..ErrorParameters::default()
                };
                (CorrelationName::Matern, parameters)
            }
        };
        let both = |of: fn(&Whiteness) -> f64| whiteness.as_ref().map(|found| [of(&found[0]), of(&found[1])]);
        ErrorsResult {
            kind,
            along: *along,
            parameters,
            effective_count: *effective_count,
            durbin_watson: both(|found| found.durbin_watson),
            ljung_box: both(|found| found.ljung_box),
            ljung_box_p: both(|found| found.ljung_box_p),
            ljung_box_lags: *lags,
        }
    }
}

/// Variances that were estimated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = VarianceResult)]
pub struct VarianceResult {
    /// For `groups`, by their names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub groups: Option<Vec<GroupSigma>>,
    /// For `power_of`: the exponent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exponent: Option<f64>,
    /// Coordinate at which the standard deviation of a height of weight 1 is `residuals.sigma`: the
    /// geometric mean of the coordinate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<f64>,
}

/// The standard deviation of a height of weight 1 of a group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct GroupSigma {
    /// Name of the group in the request.
    pub group: i64,
    /// In the unit of the heights.
    pub sigma: f64,
}

impl From<&VarianceReport> for VarianceResult {
    fn from(report: &VarianceReport) -> Self {
        match report {
            VarianceReport::Groups(groups) => VarianceResult {
                groups: Some(groups.iter().map(|&(group, sigma)| GroupSigma { group, sigma }).collect()),
                exponent: None,
                at: None,
            },
            VarianceReport::Power { exponent, at } => {
                VarianceResult { groups: None, exponent: Some(*exponent), at: Some(*at) }
            }
        }
    }
}

/// Positions of the nodes that are off. `residuals` are then vertical distances from the surface,
/// to first order, and `sigma` is the standard deviation of a height of weight 1 where the surface
/// is level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = PositionsResult)]
pub struct PositionsResult {
    pub kind: PositionKind,
    /// Rounds of the iteration.
    pub rounds: usize,
    /// Mean share of positions in the variance of the residual heights, 0 to 1.
    pub variance_share: f64,
    /// Largest distance between the measured and the estimated position of a node, in the unit of
    /// the abscissae; 0 for `nominal`.
    pub largest_shift: f64,
    /// `sigma` divided by the given `height`: far from 1 where the uncertainties do not match the
    /// residuals. Intervals use `sigma`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sigma_ratio: Option<f64>,
}

impl From<&PositionsReport> for PositionsResult {
    fn from(found: &PositionsReport) -> Self {
        PositionsResult {
            kind: found.kind,
            rounds: found.rounds,
            variance_share: found.variance_share,
            largest_shift: found.largest_shift,
            sigma_ratio: found.sigma_ratio,
        }
    }
}
