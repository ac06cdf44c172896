use flankfit_numerics::check::Fault;
use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::fault;
use crate::spec::{Along, Correlation, ErrorModel, FilterAxis, Matern};

/// Errors that are correlated along scan lines; default `independent`. Coefficients are then those
/// of generalised least squares: rows of matrix and heights are made white along the lines, and
/// spectrum, regularisation, bounds and bands are those of the white rows. Parameters that are not
/// given are estimated by restricted maximum likelihood, and estimates and intervals are averages
/// over them. For fits and surfaces of flanks; curves and surfaces near points, registrations and
/// streams refuse it.
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub(in crate::spec) enum Errors {
    /// Independent errors, the default.
    Independent {},
    /// Autoregression of first order in steps of the line; missing nodes are steps. With ρ
    /// estimated, 95 % intervals of a cubic at 60 nodes have a coverage of 0.95 to 0.97 on average
    /// and of 0.93 for the worst coefficient up to ρ = 0.9. If the correlation extends over the
    /// whole line it is lower: with ρ = 0.95 it is 0.92 on average and 0.88 for the worst
    /// (docs/explanation/errors.md).
    Ar1 {
        /// Direction of scan lines.
        #[serde(default)]
        along: Along,
        /// The line of each node as posted, any whole number; of scattered nodes and rows of a
        /// matrix, which are otherwise one line.
        #[serde(skip_serializing_if = "Option::is_none")]
        line: Option<Vec<i64>>,
        /// Default `true` without `parameters`.
        #[serde(skip_serializing_if = "Option::is_none")]
        estimate: Option<bool>,
        #[serde(skip_serializing_if = "Option::is_none")]
        parameters: Option<Ar1Parameters>,
    },
    /// Autoregression of second order in steps of the line; missing nodes are steps. Estimating it
    /// needs three nodes with two predecessors on their line.
    Ar2 {
        /// Direction of scan lines.
        #[serde(default)]
        along: Along,
        /// The line of each node as posted, any whole number; of scattered nodes and rows of a
        /// matrix, which are otherwise one line.
        #[serde(skip_serializing_if = "Option::is_none")]
        line: Option<Vec<i64>>,
        /// Default `true` without `parameters`.
        #[serde(skip_serializing_if = "Option::is_none")]
        estimate: Option<bool>,
        #[serde(skip_serializing_if = "Option::is_none")]
        parameters: Option<Ar2Parameters>,
    },
    /// Matérn's correlation (1 + x) exp(−x) with x = √3 · distance / length (smoothness 3/2), plus
    /// a share of white noise in the variance. Estimating it takes three nodes with two
    /// predecessors on their line, or neighbours at different distances.
    Matern {
        /// Direction of scan lines.
        #[serde(default)]
        along: Along,
        /// The line of each node as posted, any whole number; of scattered nodes and rows of a
        /// matrix, which are otherwise one line.
        #[serde(skip_serializing_if = "Option::is_none")]
        line: Option<Vec<i64>>,
        /// Default `true` without `parameters`.
        #[serde(skip_serializing_if = "Option::is_none")]
        estimate: Option<bool>,
        #[serde(skip_serializing_if = "Option::is_none")]
        parameters: Option<Matern>,
    },
}

/// Parameters of the first-order autoregression.
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::spec) struct Ar1Parameters {
    /// The correlation of neighbours; with `both` the same along u and along v.
    #[schema(exclusive_minimum = -1, exclusive_maximum = 1, example = 0.6)]
    rho: f64,
}

/// Parameters of the second-order autoregression.
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::spec) struct Ar2Parameters {
    /// φ₁ and φ₂, with -1 < φ₂ < 1 − |φ₁|.
    #[schema(value_type = Vec<f64>, min_items = 2, max_items = 2, example = json!([1.1, -0.5]))]
    phi: [f64; 2],
}

impl TryFrom<Errors> for ErrorModel {
    type Error = Fault;

    fn try_from(errors: Errors) -> Result<Self, Fault> {
        let (along, lines, estimate, correlation, given) = match errors {
            Errors::Independent {} => return Ok(ErrorModel(None)),
            Errors::Ar1 { along, line, estimate, parameters } => {
                let rho = parameters.map(|parameters| parameters.rho);
                (along, line, estimate, Correlation::Ar1 { rho }, rho.is_some())
            }
            Errors::Ar2 { along, line, estimate, parameters } => {
                let phi = parameters.map(|parameters| parameters.phi);
                (along, line, estimate, Correlation::Ar2 { phi }, phi.is_some())
            }
            Errors::Matern { along, line, estimate, parameters } => {
                (along, line, estimate, Correlation::Matern { parameters }, parameters.is_some())
            }
        };
        match (estimate, given) {
            (Some(true), true) => {
                Err(fault("estimate", "`parameters` are given: leave out either `estimate` or `parameters`"))
            }
            (Some(false), false) => {
                Err(fault("parameters", "missing: with `estimate` false the parameters are required"))
            }
            _ => Ok(ErrorModel(Some(super::super::Errors { correlation, along, lines }))),
        }
    }
}

impl From<ErrorModel> for Errors {
    fn from(ErrorModel(errors): ErrorModel) -> Self {
        let Some(super::super::Errors { correlation, along, lines: line }) = errors else {
            return Errors::Independent {};
        };
        let estimate = |given: bool| (!given).then_some(true);
        match correlation {
            Correlation::Ar1 { rho } => {
                let (estimate, parameters) = (estimate(rho.is_some()), rho.map(|rho| Ar1Parameters { rho }));
                Errors::Ar1 { along, line, estimate, parameters }
            }
            Correlation::Ar2 { phi } => {
                let (estimate, parameters) = (estimate(phi.is_some()), phi.map(|phi| Ar2Parameters { phi }));
                Errors::Ar2 { along, line, estimate, parameters }
            }
            Correlation::Matern { parameters } => {
                Errors::Matern { along, line, estimate: estimate(parameters.is_some()), parameters }
            }
        }
    }
}

/// Variances of the errors: `constant` (the default), `hc3`, or an object with a variance model.
/// Allowed where `errors` is.
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(untagged)]
pub(in crate::spec) enum Variance {
    Named(VarianceName),
    Estimated(EstimatedVariance),
}

/// `constant`: one variance for all nodes, divided by their weights. `hc3`: any variances; standard
/// errors are those of the sandwich HC3 about least squares, each with its own degrees of freedom.
/// With few noisy nodes 95 % intervals have a coverage of 0.94 or more for 60 nodes, and of 0.90 or
/// more for 20 (docs/explanation/errors.md).
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::spec) enum VarianceName {
    Constant,
    Hc3,
}

/// Variances that weights are estimated from by restricted maximum likelihood; either `groups` or
/// `power_of`.
#[skip_serializing_none]
#[derive(Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::spec) struct EstimatedVariance {
    /// The group of each node as posted, any whole number (grids row by row): one variance for each
    /// group.
    #[schema(min_items = 1)]
    groups: Option<Vec<i64>>,
    /// Standard deviations go as a power of the size of this coordinate (`u` is x of a curve).
    power_of: Option<FilterAxis>,
    /// The power, with `power_of`; estimated by default.
    #[schema(minimum = -6, maximum = 6)]
    exponent: Option<f64>,
}

impl TryFrom<Variance> for super::super::Variance {
    type Error = Fault;

    fn try_from(variance: Variance) -> Result<Self, Fault> {
        match variance {
            Variance::Named(VarianceName::Constant) => Ok(Self::Constant),
            Variance::Named(VarianceName::Hc3) => Ok(Self::Hc3),
            Variance::Estimated(EstimatedVariance { groups: Some(groups), power_of: None, exponent: None }) => {
                Ok(Self::Groups(groups))
            }
            Variance::Estimated(EstimatedVariance { groups: None, power_of: Some(axis), exponent }) => {
                let of = if axis == FilterAxis::V { Along::V } else { Along::U };
                Ok(Self::Power { of, exponent })
            }
            Variance::Estimated(_) => {
                Err(fault("", "give `constant`, `hc3`, or an object with either `groups` or `power_of`"))
            }
        }
    }
}

impl From<super::super::Variance> for Variance {
    fn from(variance: super::super::Variance) -> Self {
        let none = EstimatedVariance::default();
        match variance {
            super::super::Variance::Constant => Variance::Named(VarianceName::Constant),
            super::super::Variance::Hc3 => Variance::Named(VarianceName::Hc3),
            super::super::Variance::Groups(groups) => {
                Variance::Estimated(EstimatedVariance { groups: Some(groups), ..none })
            }
            super::super::Variance::Power { of, exponent } => {
                let axis = if of == Along::V { FilterAxis::V } else { FilterAxis::U };
                Variance::Estimated(EstimatedVariance { power_of: Some(axis), exponent, ..none })
            }
        }
    }
}
