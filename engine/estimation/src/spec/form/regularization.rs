use flankfit_numerics::{check::Fault, words::Shown};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::fault;
use crate::spec::{
    Attraction, Count, Criterion, DEFAULT_CONDITION_LIMIT, JamesStein, Parameter, Piece, PieceOf, Representative,
    Scheme, ShrinkageFactor, Tikhonov,
};

/// Regularisation; default spectral with its defaults.
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub(in crate::spec) enum Regularization {
    /// Plain least squares.
    None {},
    /// The matrix B of Eq. 40: the smallest eigenvalues are lifted towards λ*.
    Spectral {
        /// Default `first_order`.
        #[serde(default)]
        scheme: Scheme,
        /// Default `auto`.
        #[serde(default)]
        count: Count,
        /// With count `auto`, eigenvalues below λₙ/condition_limit are regularised.
        #[serde(default = "condition_limit")]
        #[schema(exclusive_minimum = 1, default = json!(DEFAULT_CONDITION_LIMIT))]
        condition_limit: f64,
        /// Default `{"criterion":"min_mse"}`.
        #[serde(default = "min_mse")]
        lambda_star: Parameter,
    },
    /// Ridge: every eigenvalue is lifted by k.
    Ridge {
        /// k. Default `{"criterion":"min_mse"}`.
        #[serde(default = "min_mse")]
        parameter: Parameter,
    },
    /// Tikhonov with a roughness penalty: the squared derivatives of order `order` of the fitted
    /// function, integrated over the domain in the caller's units, `w_u ∫∫ (∂ᵏf/∂uᵏ)² + w_v ∫∫
    /// (∂ᵏf/∂vᵏ)²`. For a linear model: the squared differences of that order of neighbouring
    /// coefficients, in the order of the columns.
    Tikhonov {
        /// k, the order of the derivative: 0 the function itself, 1 its slope, 2 its bending, 3 the
        /// change of its bending.
        #[schema(minimum = 0, maximum = 3)]
        order: usize,
        /// `[w_u, w_v]` for a surface, `[w]` for a curve or a linear model; at least 0, and one
        /// above 0. Default all 1.
        #[serde(skip_serializing_if = "Option::is_none")]
        #[schema(min_items = 1, max_items = 2)]
        weights: Option<Vec<f64>>,
        /// λ. Default `{"criterion":"min_mse"}`.
        #[serde(default = "min_mse")]
        parameter: Parameter,
    },
    /// Keeps only the directions of the largest singular values; allows linearly dependent columns.
    TruncatedSvd {
        /// Number of directions kept: from 1 to the rank of the scaled columns. Either this or
        /// `parameter`.
        #[serde(skip_serializing_if = "Option::is_none")]
        #[schema(minimum = 1)]
        rank: Option<usize>,
        /// Criterion that chooses the rank.
        #[serde(skip_serializing_if = "Option::is_none")]
        parameter: Option<RankParameter>,
    },
    /// James–Stein: T + c (Â − T) with a factor c that the data give.
    JamesStein {
        /// Kind of factor; default that of James and Stein, 1 − (p−2) RSS/((ν+2) Q).
        #[serde(skip_serializing_if = "Option::is_none")]
        variant: Option<JamesSteinVariant>,
        /// If true, the factor is at least 0. Default true, but false with the variants
        /// `hoerl_kennard` and `efron_morris`, which define the factor without this limit.
        #[serde(skip_serializing_if = "Option::is_none")]
        positive_part: Option<bool>,
        /// Target T, in the order of the coefficients; default 0, for `efron_morris` the grand
        /// mean. With `standardized` the constant's entry is ignored.
        #[serde(skip_serializing_if = "Option::is_none")]
        target: Option<Vec<f64>>,
    },
    /// Â is drawn to a given vector: (Â + kT)/(1 + k).
    Attraction {
        /// Target T, in the order of the coefficients; for example the coefficients of the nominal
        /// flank. With `standardized` the constant's entry is ignored.
        target: Vec<f64>,
        /// k. Default `{"criterion":"optimal"}`.
        #[serde(default = "optimal")]
        parameter: Parameter,
    },
    /// The matrix B that measurements on a representative piece gave, for others in the same
    /// directions (section 6.3 of the paper): V, λ* and L are those of the piece, X is that of
    /// these nodes. Give `iteration`, of iterations of a job and their further fits, or `piece`.
    /// The model has to be that of the piece, and so has the domain where its functions depend on
    /// it.
    Representative {
        /// Number of the iteration of the job that the piece is.
        #[serde(skip_serializing_if = "Option::is_none")]
        #[schema(minimum = 1)]
        iteration: Option<u32>,
        /// Fit of the iteration; default its chosen fit. It must be regularised by `spectral`.
        #[serde(skip_serializing_if = "Option::is_none")]
        #[schema(format = Uuid)]
        fit_id: Option<String>,
        /// Data of the piece, as returned with `include: ["representative"]`. Looked up, and stored
        /// with the fit, if `iteration` is given.
        #[serde(skip_serializing_if = "Option::is_none")]
        piece: Option<Box<Piece>>,
    },
}

/// Choice of the rank of a truncated singular value decomposition.
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::spec) struct RankParameter {
    criterion: RankCriterion,
}

/// Criteria for a rank r: `gcv`, least RSS/(m − r)²; `reml`, greatest marginal likelihood with
/// Zellner's prior of the kept coefficients; `discrepancy`, the smallest r with RSS ≤ m σ².
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::spec) enum RankCriterion {
    Gcv,
    Reml,
    Discrepancy,
}

/// Factors c of James–Stein; Q = ‖X(Â − T)‖², p directions, ν degrees of freedom, s² = RSS/ν (or σ²
/// of `noise_sigma` if it is given). `hoerl_kennard`: 1 − (p−2) s²/Q. `efron_morris`: 1 − (p−2)
/// RSS/((ν+2) Q), without a target toward the grand mean, which uses one direction (p−3).
/// `positive_part`: max(0, 1 − (p−2) RSS/((ν+2) Q)).
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::spec) enum JamesSteinVariant {
    HoerlKennard,
    EfronMorris,
    PositivePart,
}

fn condition_limit() -> f64 {
    DEFAULT_CONDITION_LIMIT
}

fn min_mse() -> Parameter {
    Parameter::Criterion(Criterion::MinMse)
}

fn optimal() -> Parameter {
    Parameter::Criterion(Criterion::Optimal)
}

impl TryFrom<Regularization> for super::super::Regularization {
    type Error = Fault;

    fn try_from(regularization: Regularization) -> Result<Self, Fault> {
        Ok(match regularization {
            Regularization::None {} => Self::None,
            Regularization::Spectral { scheme, count, condition_limit, lambda_star } => {
                check("lambda_star", lambda_star, &[])?;
                Self::Spectral { scheme, count, condition_limit, lambda_star }
            }
            Regularization::Ridge { parameter } => {
                check("parameter", parameter, &Criterion::RIDGE)?;
                Self::Ridge { parameter }
            }
            Regularization::Tikhonov { order, weights, parameter } => {
                check("parameter", parameter, &[])?;
                check_weights(weights.as_deref().unwrap_or(&[1.0]))?;
                Self::Tikhonov(Tikhonov { order, weights, parameter })
            }
            Regularization::TruncatedSvd { rank: Some(rank), parameter: None } => Self::TruncatedSvd { rank },
            Regularization::TruncatedSvd { rank: None, parameter: Some(RankParameter { criterion }) } => {
                Self::TruncatedSvdBy {
                    criterion: match criterion {
                        RankCriterion::Gcv => Criterion::Gcv,
                        RankCriterion::Reml => Criterion::Reml,
                        RankCriterion::Discrepancy => Criterion::Discrepancy,
                    },
                }
            }
            Regularization::TruncatedSvd { rank: Some(_), parameter: Some(_) } => {
                return Err(fault("parameter", "give either `rank` or `parameter`, not both"));
            }
            Regularization::TruncatedSvd { rank: None, parameter: None } => {
                let message = "missing; give it, or `parameter` with a criterion that chooses it";
                return Err(fault("rank", message));
            }
            Regularization::JamesStein { variant, positive_part, target } => {
                Self::JamesStein(james_stein(variant, positive_part, target)?)
            }
            Regularization::Attraction { target, parameter } => {
                check("parameter", parameter, &[Criterion::Optimal])?;
                Self::Attraction(Attraction { target, parameter })
            }
            Regularization::Representative { iteration: None, fit_id: Some(_), .. } => {
                return Err(fault("fit_id", "it belongs to `iteration`"));
            }
            Regularization::Representative { iteration: None, piece: None, .. } => {
                return Err(fault("", "give `iteration` or `piece`"));
            }
            Regularization::Representative { iteration, fit_id, piece } => {
                // ids have one spelling
                let fit_id = fit_id.map(|id| id.to_ascii_lowercase());
                Self::Representative(Representative { of: PieceOf { iteration, fit_id }, piece })
            }
        })
    }
}

/// Checks that a criterion is one for every regularisation, or one of its own.
fn check(path: &str, parameter: Parameter, own: &[Criterion]) -> Result<(), Fault> {
    match parameter {
        Parameter::Criterion(criterion) => {
            criterion.check_among(own).map_err(|message| fault(&format!("{path}.criterion"), message))
        }
        Parameter::Fixed(_) => Ok(()),
    }
}

fn check_weights(weights: &[f64]) -> Result<(), Fault> {
    match weights.iter().position(|weight| *weight < 0.0) {
        Some(i) => Err(fault(&format!("weights[{i}]"), format_args!("{} is negative", Shown(weights[i])))),
        None if weights.iter().all(|weight| *weight == 0.0) => {
            Err(fault("weights", "one weight for each axis, at least one greater than 0"))
        }
        None => Ok(()),
    }
}

fn james_stein(
    variant: Option<JamesSteinVariant>,
    positive_part: Option<bool>,
    target: Option<Vec<f64>>,
) -> Result<JamesStein, Fault> {
    let (factor, positive_part) = match (variant, positive_part) {
        (None, positive) => (ShrinkageFactor::JamesStein, positive.unwrap_or(true)),
        (Some(JamesSteinVariant::HoerlKennard), positive) => (ShrinkageFactor::HoerlKennard, positive.unwrap_or(false)),
        (Some(JamesSteinVariant::EfronMorris), positive) => (ShrinkageFactor::EfronMorris, positive.unwrap_or(false)),
        (Some(JamesSteinVariant::PositivePart), None | Some(true)) => (ShrinkageFactor::JamesStein, true),
        (Some(JamesSteinVariant::PositivePart), Some(false)) => {
            let message = "false contradicts the variant `positive_part`; leave one of them out";
            return Err(fault("positive_part", message));
        }
    };
    Ok(JamesStein { factor, positive_part, target })
}

impl From<super::super::Regularization> for Regularization {
    fn from(regularization: super::super::Regularization) -> Self {
        match regularization {
            super::super::Regularization::None => Regularization::None {},
            super::super::Regularization::Spectral { scheme, count, condition_limit, lambda_star } => {
                Regularization::Spectral { scheme, count, condition_limit, lambda_star }
            }
            super::super::Regularization::Ridge { parameter } => Regularization::Ridge { parameter },
            super::super::Regularization::Tikhonov(Tikhonov { order, weights, parameter }) => {
                Regularization::Tikhonov { order, weights, parameter }
            }
            super::super::Regularization::TruncatedSvd { rank } => {
                Regularization::TruncatedSvd { rank: Some(rank), parameter: None }
            }
            super::super::Regularization::TruncatedSvdBy { criterion } => {
                let criterion = match criterion {
                    Criterion::Reml => RankCriterion::Reml,
                    Criterion::Discrepancy => RankCriterion::Discrepancy,
                    _ => RankCriterion::Gcv,
                };
                Regularization::TruncatedSvd { rank: None, parameter: Some(RankParameter { criterion }) }
            }
            super::super::Regularization::JamesStein(JamesStein { factor, positive_part, target }) => {
                let variant = match (factor, positive_part) {
                    (ShrinkageFactor::HoerlKennard, _) => Some(JamesSteinVariant::HoerlKennard),
                    (ShrinkageFactor::EfronMorris, _) => Some(JamesSteinVariant::EfronMorris),
                    (ShrinkageFactor::JamesStein, true) => Some(JamesSteinVariant::PositivePart),
                    (ShrinkageFactor::JamesStein, false) => None,
                };
                Regularization::JamesStein { variant, positive_part: Some(positive_part), target }
            }
            super::super::Regularization::Attraction(Attraction { target, parameter }) => {
                Regularization::Attraction { target, parameter }
            }
            super::super::Regularization::Representative(Representative { of, piece }) => {
                let PieceOf { iteration, fit_id } = of;
                Regularization::Representative { iteration, fit_id, piece }
            }
        }
    }
}
