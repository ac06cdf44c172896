//! Error models of the heights.

#[cfg(feature = "contract")]
use super::form;

/// Direction of scan lines: `u` (columns of a grid; profiles of a flank), `v` (rows; helices of a
/// flank), `both` (the correlation of two nodes of a full grid is the product of those along u and
/// v), or `order`: along the abscissae of a curve, in the order posted for other nodes, and on a
/// grid in the direction that the residuals show: u, v, or both if neither alone is enough.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum Along {
    /// Along u at each v: the columns of a grid.
    U,
    /// Along v at each u: the rows of a grid.
    V,
    /// Along both axes of a grid.
    Both,
    /// Along the abscissae of a curve, in the order posted, or as the residuals of a grid show.
    #[default]
    Order,
}

impl Along {
    /// Name in the interface.
    pub fn name(self) -> &'static str {
        match self {
            Along::U => "u",
            Along::V => "v",
            Along::Both => "both",
            Along::Order => "order",
        }
    }
}

/// Errors that are correlated along scan lines.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Along, Correlation, Errors, Model},
/// };
///
/// // Heights about a mean, each like the one before it.
/// let y = vec![0.3, 0.5, 0.8, 0.6, 0.1, -0.4, -0.3, -0.6, -0.1, 0.2, 0.5, 0.4];
/// let nodes = Nodes::matrix(vec![1.0; 12], 1, y, None, None)?;
/// let spec = FitSpec::new(Model::Linear);
/// let of = |rho: f64| {
///     let errors = Errors {
///         correlation: Correlation::Ar1 { rho: Some(rho) },
///         along: Along::Order,
///         lines: None,
///     };
///     fit(&nodes, &FitSpec { errors: Some(errors), ..spec.clone() })
/// };
///
/// // Uncorrelated they are those of any fit; correlated they tell less of the mean.
/// let (white, correlated) = (of(0.0)?, of(0.8)?);
/// assert_eq!(white.coefficients[0].std_error, fit(&nodes, &spec)?.coefficients[0].std_error);
/// assert!(correlated.coefficients[0].std_error > white.coefficients[0].std_error);
/// // As many independent heights tell as much: (12 − 10 · 0.8)/1.8.
/// let count = correlated.errors.expect("they were asked for").effective_count;
/// assert!((count - 4.0 / 1.8).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Errors {
    /// Correlation of the errors.
    pub correlation: Correlation,
    /// Direction of the lines.
    pub along: Along,
    /// The line of each posted node, where scattered nodes or rows of a matrix were measured along
    /// several.
    pub lines: Option<Vec<i64>>,
}

/// Correlations along a line; parameters that are not given are estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Correlation {
    /// Autoregression of first order in steps of the line.
    Ar1 {
        /// The correlation of neighbours.
        rho: Option<f64>,
    },
    /// Autoregression of second order.
    Ar2 {
        /// φ₁ and φ₂.
        phi: Option<[f64; 2]>,
    },
    /// Matérn's correlation with smoothness 3/2 in the unit of the abscissae.
    Matern {
        /// The length, and the share of the variance that is white.
        parameters: Option<Matern>,
    },
}

/// Parameters of Matérn's correlation `(1 + x) exp(−x)`, x = √3 d/length.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(deny_unknown_fields),
    schema(as = MaternParameters)
)]
pub struct Matern {
    /// Distance over which errors are correlated, in the unit of the abscissae.
    #[cfg_attr(feature = "contract", schema(exclusive_minimum = 0))]
    pub length: f64,
    /// The white share of the variance.
    #[cfg_attr(feature = "contract", serde(default), schema(minimum = 0, exclusive_maximum = 1, default = 0.0))]
    pub nugget: f64,
}

/// Variances of the errors in addition to the weights.
#[derive(Clone, Debug, PartialEq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "form::Variance", into = "form::Variance")
)]
pub enum Variance {
    /// One for all.
    #[default]
    Constant,
    /// Any: the sandwich HC3 about least squares.
    Hc3,
    /// One for each group of nodes, estimated: the group of each posted node.
    Groups(Vec<i64>),
    /// Standard deviations that go as a power of a coordinate.
    Power {
        /// The coordinate: u (x of a curve) or v.
        of: Along,
        /// The power; estimated where `None`.
        exponent: Option<f64>,
    },
}

/// An error model as it is written: `None` where errors are independent.
#[derive(Clone, Debug, PartialEq)]
#[cfg(feature = "contract")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(try_from = "form::Errors", into = "form::Errors")]
pub struct ErrorModel(pub Option<Errors>);
