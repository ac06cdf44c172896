//! Which estimator a request asks for, as it is written, and its canonical form with every default
//! filled in.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::contamination::{ContaminationBody, EstimateName};
use crate::api::json::present::present;
use flankfit_engine::estimation::spec::{
    Contamination, Distribution, Estimator, LEstimator, Loss, MEstimator, ScaleRule, Start,
};

/// Estimator of the coefficients; default `least_squares`. Weights of nodes multiply squared
/// residuals for every estimator: rows and heights are scaled by √weight.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = Estimator, discriminator(property_name = "type", mapping(
    ("least_squares" = "#/components/schemas/LeastSquaresEstimator"),
    ("m_estimator" = "#/components/schemas/MEstimator"),
    ("least_absolute_deviations" = "#/components/schemas/LeastAbsoluteDeviationsEstimator"),
    ("lp" = "#/components/schemas/LpEstimator"),
    ("quantile" = "#/components/schemas/QuantileEstimator"),
    ("least_trimmed_squares" = "#/components/schemas/LeastTrimmedSquaresEstimator"),
    ("rank" = "#/components/schemas/RankEstimator"),
    ("l_estimator" = "#/components/schemas/LEstimator"),
    ("maximum_likelihood" = "#/components/schemas/MaximumLikelihoodEstimator")
)))]
pub enum EstimatorBody {
    LeastSquares(LeastSquaresEstimator),
    M(MEstimatorBody),
    LeastAbsoluteDeviations(LeastAbsoluteDeviationsEstimator),
    Lp(LpEstimator),
    Quantile(QuantileEstimator),
    LeastTrimmedSquares(LeastTrimmedSquaresEstimator),
    Rank(RankEstimator),
    L(LEstimatorBody),
    MaximumLikelihood(MaximumLikelihoodEstimator),
}

/// Least squares, the default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LeastSquaresEstimator {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: LeastSquaresTag,
}

/// Least Σρ(r/s) by iteratively reweighted least squares (Eqs. 10–12); regularisation and
/// diagnostics act on the weighted matrix.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = MEstimator)]
pub struct MEstimatorBody {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: MEstimatorTag,
    pub loss: LossName,
    /// In units of the scale: k of Huber (default 1.345), c of Tukey (4.685), a, b, c of Hampel (2,
    /// 4, 8), a of Andrews (1.339).
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1, max_items = 3, example = json!([1.345]))]
    pub tuning: Option<Vec<f64>>,
    /// For `huber`, instead of `tuning`: the share ε of gross errors, which gives the minimax k
    /// (Eq. 10), or `estimate`: the ε of the least favourable distribution that maximises the
    /// likelihood of the residuals.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub contamination: Option<ContaminationBody>,
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub scale: Option<ScaleBody>,
    /// The iteration ends when no residual and not the scale moves by more than this many scales.
    /// Default 1e-13.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0, maximum = 0.1)]
    pub tolerance: Option<f64>,
    /// Default 1000.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 10000)]
    pub max_iterations: Option<usize>,
    /// Default `least_squares`.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub start: Option<StartName>,
}

/// The scale of residuals, found anew in each iteration; default `mad_0_6745`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ResidualScale)]
pub struct ScaleBody {
    pub rule: ScaleRuleName,
    /// `fixed`: the scale itself, in the unit of the heights (needed). `proposal2`: k₂, default
    /// 1.345. Else not taken.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0)]
    pub value: Option<f64>,
}

/// Least Σ|r|, solved exactly, with a certificate of optimality.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LeastAbsoluteDeviationsEstimator {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: LeastAbsoluteDeviationsTag,
}

/// Least Σ|r|^p.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LpEstimator {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: LpTag,
    /// Power p of the minimised sum Σ|r|^p: 1 is least absolute deviations, 2 least squares.
    #[schema(minimum = 1, maximum = 2)]
    pub p: f64,
}

/// Regression quantile: a share `tau` of the nodes lies below the surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct QuantileEstimator {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: QuantileTag,
    /// Share of the nodes that shall lie below, between 0 and 1; 0.5 is the median.
    #[schema(exclusive_minimum = 0, exclusive_maximum = 1)]
    pub tau: f64,
}

/// Least sum of the h smallest squares (FAST-LTS; every subset is tried where there are few).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LeastTrimmedSquaresEstimator {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: LeastTrimmedSquaresTag,
    /// Share of nodes in the sum: h = ⌊coverage·m⌋, at least ⌊(m + n + 1)/2⌋. Default 0.75.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0.5, maximum = 1)]
    pub coverage: Option<f64>,
    /// Seed of the random starts; the same seed gives the same answer. Default 0.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 9007199254740991i64)]
    pub seed: Option<u64>,
}

/// Least rank dispersion (Jaeckel), with Wilcoxon scores solved exactly; the constant is set by
/// the median of the residuals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RankEstimator {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: RankTag,
    /// Default `wilcoxon`.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub scores: Option<ScoresName>,
}

/// Linear combinations of order statistics, by regression quantiles (Koenker and Bassett).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = LEstimator)]
pub struct LEstimatorBody {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: LEstimatorTag,
    pub form: LEstimatorForm,
    /// For `trimmed` and `winsorized`: share of the nodes at either end. Default 0.1.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0, exclusive_maximum = 0.5)]
    pub share: Option<f64>,
    /// For `quantiles`, required there: τ of each, ascending.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1, max_items = 9, example = json!([0.25, 0.5, 0.75]))]
    pub quantiles: Option<Vec<f64>>,
    /// For `quantiles`, required there: the weight of each, summing to 1.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1, max_items = 9, example = json!([0.25, 0.5, 0.25]))]
    pub weights: Option<Vec<f64>>,
}

/// Greatest likelihood for errors that are not normal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MaximumLikelihoodEstimator {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: MaximumLikelihoodTag,
    pub distribution: DistributionName,
    /// ν of `student`, 0.5 to 200; p of `generalized_normal`, 1 to 8. Estimated by default.
    /// `laplace` has no shape.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0.5, maximum = 200)]
    pub shape: Option<f64>,
}

/// Declares names that are written in snake case.
macro_rules! names {
    ($($(#[$doc:meta])* $name:ident { $($value:ident),* $(,)? })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum $name {
            $($value,)*
        }
    )*};
}

names! {
    /// The variant.
    LeastSquaresTag { LeastSquares }
    /// The variant.
    MEstimatorTag { MEstimator }
    /// The variant.
    LeastAbsoluteDeviationsTag { LeastAbsoluteDeviations }
    /// The variant.
    LpTag { Lp }
    /// The variant.
    QuantileTag { Quantile }
    /// The variant.
    LeastTrimmedSquaresTag { LeastTrimmedSquares }
    /// The variant.
    RankTag { Rank }
    /// The variant.
    LEstimatorTag { LEstimator }
    /// The variant.
    MaximumLikelihoodTag { MaximumLikelihood }
    /// Nodes beyond two regression quantiles left out (`trimmed`), or moved to them (`winsorized`);
    /// several regression quantiles with weights (`quantiles`).
    LEstimatorForm { Trimmed, Winsorized, Quantiles }
    /// The distribution of the errors; `generalized_normal` has the density exp(−(|r|/a)^p), up to
    /// a factor.
    DistributionName { Student, Laplace, GeneralizedNormal }
    /// Huber's is convex; the others give far nodes no weight at all and may have several local
    /// solutions.
    LossName { Huber, Tukey, Hampel, Andrews }
    /// Start of an iteration; least trimmed squares of half the nodes tolerates gross errors in
    /// nearly half of them.
    StartName { LeastSquares, LeastTrimmedSquares }
    /// Scores of ranks: `wilcoxon` i/(m + 1) − 1/2, `normal` (van der Waerden) Φ⁻¹(i/(m + 1)).
    ScoresName { Wilcoxon, Normal }
}

/// MAD about 0 divided by 0.6745 or by Φ⁻¹(0.75), Huber's proposal 2, or the caller's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ScaleRuleName {
    #[serde(rename = "mad_0_6745")]
    Mad06745,
    Mad,
    Proposal2,
    Fixed,
}

/// Largest integer that every JSON client can hold.
pub const MOST_SEED: u64 = (1 << 53) - 1;

impl From<Start> for StartName {
    fn from(start: Start) -> Self {
        match start {
            Start::LeastSquares => StartName::LeastSquares,
            Start::LeastTrimmed => StartName::LeastTrimmedSquares,
        }
    }
}

impl From<StartName> for Start {
    fn from(name: StartName) -> Self {
        match name {
            StartName::LeastSquares => Start::LeastSquares,
            StartName::LeastTrimmedSquares => Start::LeastTrimmed,
        }
    }
}

impl LossName {
    /// The loss with its default tuning.
    pub fn usual(self) -> Loss {
        match self {
            LossName::Huber => Loss::HUBER,
            LossName::Tukey => Loss::TUKEY,
            LossName::Hampel => Loss::HAMPEL,
            LossName::Andrews => Loss::ANDREWS,
        }
    }
}

impl From<&Estimator> for EstimatorBody {
    fn from(estimator: &Estimator) -> Self {
        match estimator {
            Estimator::LeastSquares => {
                EstimatorBody::LeastSquares(LeastSquaresEstimator { kind: LeastSquaresTag::LeastSquares })
            }
            Estimator::M(m) => EstimatorBody::M(m_estimator(m)),
            Estimator::LeastAbsolute => EstimatorBody::LeastAbsoluteDeviations(LeastAbsoluteDeviationsEstimator {
                kind: LeastAbsoluteDeviationsTag::LeastAbsoluteDeviations,
            }),
            Estimator::Lp { p } => EstimatorBody::Lp(LpEstimator { kind: LpTag::Lp, p: *p }),
            Estimator::Quantile { tau } => {
                EstimatorBody::Quantile(QuantileEstimator { kind: QuantileTag::Quantile, tau: *tau })
            }
            Estimator::LeastTrimmed { coverage, seed } => {
                EstimatorBody::LeastTrimmedSquares(LeastTrimmedSquaresEstimator {
                    kind: LeastTrimmedSquaresTag::LeastTrimmedSquares,
                    coverage: Some(*coverage),
                    seed: Some(*seed),
                })
            }
            Estimator::Rank => {
                EstimatorBody::Rank(RankEstimator { kind: RankTag::Rank, scores: Some(ScoresName::Wilcoxon) })
            }
            Estimator::NormalScores => {
                EstimatorBody::Rank(RankEstimator { kind: RankTag::Rank, scores: Some(ScoresName::Normal) })
            }
            Estimator::L(asked) => EstimatorBody::L(l_estimator(asked)),
            Estimator::Likelihood(distribution) => EstimatorBody::MaximumLikelihood(likelihood(*distribution)),
        }
    }
}

fn l_estimator(asked: &LEstimator) -> LEstimatorBody {
    let of =
        |form, share| LEstimatorBody { kind: LEstimatorTag::LEstimator, form, share, quantiles: None, weights: None };
    match asked {
        LEstimator::Trimmed { share } => of(LEstimatorForm::Trimmed, Some(*share)),
        LEstimator::Winsorized { share } => of(LEstimatorForm::Winsorized, Some(*share)),
        LEstimator::Quantiles(weights) => {
            let part = |at: usize| Some(weights.pairs().iter().map(|pair| pair[at]).collect());
            LEstimatorBody { quantiles: part(0), weights: part(1), ..of(LEstimatorForm::Quantiles, None) }
        }
    }
}

fn likelihood(distribution: Distribution) -> MaximumLikelihoodEstimator {
    let (name, shape) = match distribution {
        Distribution::Student { freedom } => (DistributionName::Student, freedom),
        Distribution::Laplace => (DistributionName::Laplace, None),
        Distribution::GeneralizedNormal { exponent } => (DistributionName::GeneralizedNormal, exponent),
    };
    MaximumLikelihoodEstimator { kind: MaximumLikelihoodTag::MaximumLikelihood, distribution: name, shape }
}

fn m_estimator(m: &MEstimator) -> MEstimatorBody {
    let (loss, tuning) = match m.loss {
        Loss::Huber { k } => (LossName::Huber, vec![k]),
        Loss::Tukey { c } => (LossName::Tukey, vec![c]),
        Loss::Hampel { a, b, c } => (LossName::Hampel, vec![a, b, c]),
        Loss::Andrews { a } => (LossName::Andrews, vec![a]),
    };
    let (rule, value) = match m.scale {
        ScaleRule::Mad06745 => (ScaleRuleName::Mad06745, None),
        ScaleRule::Mad => (ScaleRuleName::Mad, None),
        ScaleRule::Proposal2 { k2 } => (ScaleRuleName::Proposal2, Some(k2)),
        ScaleRule::Fixed(value) => (ScaleRuleName::Fixed, Some(value)),
    };
    MEstimatorBody {
        kind: MEstimatorTag::MEstimator,
        loss,
        tuning: m.contamination.is_none().then_some(tuning),
        contamination: m.contamination.map(|contamination| match contamination {
            Contamination::Share(share) => ContaminationBody::Share(share),
            Contamination::Estimated => ContaminationBody::Estimate(EstimateName::Estimate),
        }),
        scale: Some(ScaleBody { rule, value }),
        tolerance: Some(m.tolerance),
        max_iterations: Some(m.max_iterations),
        start: Some(m.start.into()),
    }
}
