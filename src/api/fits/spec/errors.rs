//! Models of the errors, as they are written.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::json::{present::present, tags::tags};
use flankfit_engine::estimation::spec::{Along, Correlation, Errors, Matern, Variance};

/// Errors that are correlated along scan lines; default `independent`. Coefficients are then those
/// of generalised least squares: rows of matrix and heights are made white along the lines, and
/// spectrum, regularisation, bounds and bands are those of the white rows. Parameters that are not
/// given are estimated by restricted maximum likelihood, and estimates and intervals are averages
/// over them. For fits and surfaces of flanks; curves and surfaces near points, registrations and
/// streams refuse it.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = Errors, discriminator(property_name = "type", mapping(
    ("independent" = "#/components/schemas/IndependentErrors"),
    ("ar1" = "#/components/schemas/Ar1Errors"),
    ("ar2" = "#/components/schemas/Ar2Errors"),
    ("matern" = "#/components/schemas/MaternErrors")
)))]
pub enum ErrorsBody {
    Independent(IndependentErrors),
    Ar1(Ar1Errors),
    Ar2(Ar2Errors),
    Matern(MaternErrors),
}

/// Independent errors, the default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct IndependentErrors {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: IndependentTag,
}

/// Declares a correlation with its parameters.
macro_rules! correlated {
    ($(#[$meta:meta])* $name:ident, $tag:ident, $parameters:ident) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            #[serde(rename = "type")]
            #[schema(inline)]
            pub kind: $tag,
            /// Direction of scan lines. Required for a grid; default `order`.
            #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
            pub along: Option<AlongName>,
            /// The line of each node as posted, any whole number; of scattered nodes and rows of a
            /// matrix, which are else one line.
            #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
            pub line: Option<Vec<i64>>,
            /// `true`, the default, where there are no `parameters`.
            #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
            pub estimate: Option<bool>,
            #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
            pub parameters: Option<$parameters>,
        }
    };
}

correlated! {
    /// Autoregression of first order in steps of the line; missing nodes are steps. With ρ
    /// estimated, 95 % intervals of a cubic at 60 nodes hold in 0.95 to 0.97 on average and in 0.93
    /// for the worst coefficient up to ρ = 0.9. Where the correlation reaches over the whole line
    /// they do not: with ρ = 0.95 in 0.92 on average and in 0.88 for the worst (docs/errors.md).
    Ar1Errors, Ar1Tag, Ar1Parameters
}
correlated! {
    /// Autoregression of second order in steps of the line; missing nodes are steps. Estimating it
    /// takes three nodes with two predecessors on their line.
    Ar2Errors, Ar2Tag, Ar2Parameters
}
correlated! {
    /// Matérn's correlation (1 + x) exp(−x) with x = √3 · distance / length (smoothness 3/2), plus
    /// a share of white noise in the variance. Estimating it takes three nodes with two
    /// predecessors on their line, or neighbours at different distances.
    MaternErrors, MaternTag, MaternParameters
}

/// Parameters of the first-order autoregression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Ar1Parameters {
    /// The correlation of neighbours.
    #[schema(exclusive_minimum = -1, exclusive_maximum = 1, example = 0.6)]
    pub rho: f64,
}

/// Parameters of the second-order autoregression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Ar2Parameters {
    /// φ₁ and φ₂, with -1 < φ₂ < 1 − |φ₁|.
    #[schema(min_items = 2, max_items = 2, example = json!([1.1, -0.5]))]
    pub phi: [f64; 2],
}

/// Parameters of Matérn's correlation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MaternParameters {
    /// Distance over which errors are alike, in the unit of the abscissae.
    #[schema(exclusive_minimum = 0)]
    pub length: f64,
    /// The white share of the variance; default 0.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, exclusive_maximum = 1)]
    pub nugget: Option<f64>,
}

tags! {
    IndependentTag = Independent,
    Ar1Tag = Ar1,
    Ar2Tag = Ar2,
    MaternTag = Matern,
}

/// Direction of scan lines: `u` (columns of a grid; profiles of a flank), `v` (rows; helices of a
/// flank), or `order`: along the abscissae of a curve, and in the order posted for other nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum AlongName {
    U,
    V,
    Order,
}

impl From<AlongName> for Along {
    fn from(name: AlongName) -> Self {
        match name {
            AlongName::U => Along::U,
            AlongName::V => Along::V,
            AlongName::Order => Along::Order,
        }
    }
}

impl From<Along> for AlongName {
    fn from(along: Along) -> Self {
        match along {
            Along::U => AlongName::U,
            Along::V => AlongName::V,
            Along::Order => AlongName::Order,
        }
    }
}

impl From<&Errors> for ErrorsBody {
    fn from(errors: &Errors) -> Self {
        let (along, line) = (Some(errors.along.into()), errors.lines.clone());
        let estimate = |given: bool| (!given).then_some(true);
        match errors.correlation {
            Correlation::Ar1 { rho } => {
                let parameters = rho.map(|rho| Ar1Parameters { rho });
                ErrorsBody::Ar1(Ar1Errors {
                    kind: Ar1Tag::Ar1,
                    along,
                    line,
                    estimate: estimate(rho.is_some()),
                    parameters,
                })
            }
            Correlation::Ar2 { phi } => {
                let parameters = phi.map(|phi| Ar2Parameters { phi });
                ErrorsBody::Ar2(Ar2Errors {
                    kind: Ar2Tag::Ar2,
                    along,
                    line,
                    estimate: estimate(phi.is_some()),
                    parameters,
                })
            }
            Correlation::Matern { parameters } => {
                let told =
                    parameters.map(|Matern { length, nugget }| MaternParameters { length, nugget: Some(nugget) });
                let estimate = estimate(told.is_some());
                ErrorsBody::Matern(MaternErrors { kind: MaternTag::Matern, along, line, estimate, parameters: told })
            }
        }
    }
}

/// Variances of the errors: `constant` (the default), `hc3`, or an object with a variance model.
/// Allowed where `errors` is.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = Variance)]
pub enum VarianceBody {
    Named(VarianceName),
    Estimated(EstimatedVariance),
}

/// `constant`: one variance for all nodes, divided by their weights. `hc3`: any variances; standard
/// errors are those of the sandwich HC3 about least squares, each with its own degrees of freedom.
/// With few noisy nodes 95 % intervals have a coverage of 0.94 or more for 60 nodes, and of 0.90 or
/// more for 20 (docs/errors.md).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum VarianceName {
    Constant,
    Hc3,
}

/// Variances that weights are estimated from by restricted maximum likelihood; either `groups` or
/// `power_of`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct EstimatedVariance {
    /// The group of each node as posted, any whole number (grids row by row): one variance for each
    /// group.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1)]
    pub groups: Option<Vec<i64>>,
    /// Standard deviations go as a power of the size of this coordinate (`u` is x of a curve).
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub power_of: Option<CoordinateName>,
    /// The power, with `power_of`; estimated where it is left out.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(minimum = -6, maximum = 6)]
    pub exponent: Option<f64>,
}

/// A coordinate of the nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum CoordinateName {
    U,
    V,
}

/// As it is written; `None` for the default.
pub fn written(variance: &Variance) -> Option<VarianceBody> {
    let estimated =
        |groups, power_of, exponent| VarianceBody::Estimated(EstimatedVariance { groups, power_of, exponent });
    match variance {
        Variance::Constant => None,
        Variance::Hc3 => Some(VarianceBody::Named(VarianceName::Hc3)),
        Variance::Groups(groups) => Some(estimated(Some(groups.clone()), None, None)),
        Variance::Power { of, exponent } => {
            let name = if *of == Along::V { CoordinateName::V } else { CoordinateName::U };
            Some(estimated(None, Some(name), *exponent))
        }
    }
}
