//! The regularisation in a fit's answer. Names and meanings are the contract's.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

pub use crate::api::fits::spec::criteria::ChosenBy;
use crate::api::fits::spec::request::SchemeName;

/// How the estimate was regularised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum RegularizationName {
    None,
    Spectral,
    Ridge,
    Tikhonov,
    TruncatedSvd,
    JamesStein,
    Attraction,
}

/// The regularisation that was applied, and what every criterion would have chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RegularizationResult {
    #[serde(rename = "type")]
    pub kind: RegularizationName,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scheme: Option<SchemeName>,
    /// L: how many of the smallest eigenvalues were regularised.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// λ* of the spectral schemes, k of ridge and attraction, λ of Tikhonov; absent when nothing
    /// was regularised and where there is none (truncated SVD, James–Stein, an attraction of
    /// infinite weight).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lambda_star: Option<f64>,
    /// Directions that a truncated singular value decomposition keeps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rank: Option<usize>,
    /// c of James–Stein and attraction: what is left of Â − T.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shrinkage_factor: Option<f64>,
    /// The plateau of minimisers of Eq. 49, where there is one: [lo, hi].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Vec<f64>>, min_items = 2, max_items = 2)]
    pub lambda_star_interval: Option<[f64; 2]>,
    /// λ* − λ₁.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gamma: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub criterion: Option<ChosenBy>,
    /// What is left of each direction: 1 is all. In the order of `spectrum.eigenvalues`; for
    /// Tikhonov the directions are those of matrix and penalty together, the most penalised first.
    pub filter_factors: Vec<f64>,
    /// ‖B‖² (Eq. 41).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matrix_norm_squared: Option<f64>,
    /// Ineq. 48.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_eigenvalue_bound: Option<f64>,
    /// Every criterion, and least squares, side by side.
    pub choices: Vec<ChoiceBody>,
}

/// What one criterion would choose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Choice)]
pub struct ChoiceBody {
    pub criterion: ChosenBy,
    /// The λ* that the criterion would choose, as an eigenvalue of the scaled Fisher information
    /// matrix.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lambda_star: Option<f64>,
    /// Condition number of the regularised matrix; left out where it is infinite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    /// ‖Â − Â_B‖ in the scaled columns.
    pub bias_norm: f64,
    /// Predicted mean squared error of the coefficients in the scaled columns: good for comparing
    /// criteria on the same nodes. That of the chosen one is too small, about 0.4 of the true error
    /// in simulations (docs/mathematics-notes.md).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub predicted_mse: Option<f64>,
    /// Root mean square of the residuals, in the unit of the heights.
    pub rms: f64,
}

/// The coefficients of ridge at one k.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = RidgeTracePoint)]
pub struct RidgeTracePointBody {
    /// The constant added to the eigenvalues of the scaled Fisher information matrix.
    pub k: f64,
    /// In the caller's terms, in the order of the answer's `coefficients`.
    pub coefficients: Vec<f64>,
}
