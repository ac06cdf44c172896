//! What a fit request asks for by way of regularisation, as it is written.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::count::CountBody;
pub use super::criteria::CriterionName;
use super::{representative::RepresentativeRegularization, scheme::SchemeName};
use crate::api::json::{present::present, tags::tags};
use flankfit_engine::estimation::spec::DEFAULT_CONDITION_LIMIT;

/// Regularisation; default spectral with its defaults.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = Regularization, discriminator(property_name = "type", mapping(
    ("none" = "#/components/schemas/NoRegularization"),
    ("spectral" = "#/components/schemas/SpectralRegularization"),
    ("ridge" = "#/components/schemas/RidgeRegularization"),
    ("tikhonov" = "#/components/schemas/TikhonovRegularization"),
    ("truncated_svd" = "#/components/schemas/TruncatedSvdRegularization"),
    ("james_stein" = "#/components/schemas/JamesSteinRegularization"),
    ("attraction" = "#/components/schemas/AttractionRegularization"),
    ("representative" = "#/components/schemas/RepresentativeRegularization")
)))]
pub enum RegularizationBody {
    None(NoRegularization),
    Spectral(SpectralRegularization),
    Ridge(RidgeRegularization),
    Tikhonov(TikhonovRegularization),
    TruncatedSvd(TruncatedSvdRegularization),
    JamesStein(JamesSteinRegularization),
    Attraction(AttractionRegularization),
    Representative(Box<RepresentativeRegularization>),
}

/// Plain least squares.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NoRegularization {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: NoneTag,
}

/// The matrix B of Eq. 40: the smallest eigenvalues are lifted towards λ*.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SpectralRegularization {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: SpectralTag,
    /// Default `first_order`.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub scheme: Option<SchemeName>,
    /// Default `auto`.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub count: Option<CountBody>,
    /// With count `auto`, eigenvalues below λₙ/condition_limit are regularised. Default 900.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 1, default = json!(DEFAULT_CONDITION_LIMIT))]
    pub condition_limit: Option<f64>,
    /// Default `min_mse`.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub lambda_star: Option<ParameterBody>,
}

/// Ridge: every eigenvalue is lifted by k.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RidgeRegularization {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: RidgeTag,
    /// k. Default `min_mse`.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub parameter: Option<ParameterBody>,
}

/// Tikhonov with a roughness penalty: the squared derivatives of order `order` of the fitted
/// function, integrated over the domain in the caller's units, `w_u ∫∫ (∂ᵏf/∂uᵏ)² + w_v ∫∫
/// (∂ᵏf/∂vᵏ)²`. For a linear model: the squared differences of that order of neighbouring
/// coefficients, in the order of the columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TikhonovRegularization {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: TikhonovTag,
    /// k, the order of the derivative: 0 the function itself, 1 its slope, 2 its bending, 3 the
    /// change of its bending.
    #[schema(minimum = 0, maximum = 3)]
    pub order: usize,
    /// `[w_u, w_v]` for a surface, `[w]` for a curve or a linear model; at least 0, and one above
    /// 0. Default all 1.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1, max_items = 2)]
    pub weights: Option<Vec<f64>>,
    /// λ. Default `min_mse`.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub parameter: Option<ParameterBody>,
}

/// Keeps only the directions of the largest singular values; allows linearly dependent columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TruncatedSvdRegularization {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: TruncatedSvdTag,
    /// Number of directions kept: from 1 to the rank of the scaled columns. Either this or
    /// `parameter`.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1)]
    pub rank: Option<usize>,
    /// Criterion that chooses the rank.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub parameter: Option<RankParameterBody>,
}

/// Choice of the rank of a truncated singular value decomposition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = RankParameter)]
pub struct RankParameterBody {
    pub criterion: RankCriterionName,
}

/// Criteria for a rank r: `gcv`, least RSS/(m − r)²; `reml`, greatest marginal likelihood with
/// Zellner's prior of the kept coefficients; `discrepancy`, the smallest r with RSS ≤ m σ².
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = RankCriterion)]
pub enum RankCriterionName {
    Gcv,
    Reml,
    Discrepancy,
}

/// James–Stein: T + c (Â − T) with a factor c that the data give.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct JamesSteinRegularization {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: JamesSteinTag,
    /// Which factor; without it that of James and Stein, 1 − (p−2) RSS/((ν+2) Q).
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub variant: Option<JamesSteinVariant>,
    /// If true, the factor is at least 0. Default true, but false with the variants `hoerl_kennard`
    /// and `efron_morris`, which define the factor without this limit.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub positive_part: Option<bool>,
    /// Target T, in the order of the coefficients; default 0, for `efron_morris` the grand mean.
    /// With `standardized` the constant's entry is ignored.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub target: Option<Vec<f64>>,
}

/// Â is drawn to a given vector: (Â + kT)/(1 + k).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct AttractionRegularization {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: AttractionTag,
    /// Target T, in the order of the coefficients; for example the coefficients of the nominal
    /// flank. With `standardized` the constant's entry is ignored.
    pub target: Vec<f64>,
    /// k. Default `optimal`.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub parameter: Option<ParameterBody>,
}

/// Factors c of James–Stein; Q = ‖X(Â − T)‖², p directions, ν degrees of freedom, s² = RSS/ν (or σ²
/// of `noise_sigma` if it is given). `hoerl_kennard`: 1 − (p−2) s²/Q. `efron_morris`: 1 − (p−2)
/// RSS/((ν+2) Q), without a target toward the grand mean, which uses one direction (p−3).
/// `positive_part`: max(0, 1 − (p−2) RSS/((ν+2) Q)).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JamesSteinVariant {
    HoerlKennard,
    EfronMorris,
    PositivePart,
}

/// Choice of λ* (spectral), k (ridge, attraction) or λ (Tikhonov).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Parameter)]
pub struct ParameterBody {
    pub criterion: CriterionName,
    /// The value itself, in the scaled columns; with criterion `fixed` and only then.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0)]
    pub value: Option<f64>,
}

tags! {
    NoneTag = None,
    SpectralTag = Spectral,
    RidgeTag = Ridge,
    TikhonovTag = Tikhonov,
    TruncatedSvdTag = TruncatedSvd,
    JamesSteinTag = JamesStein,
    AttractionTag = Attraction,
}
