use flankfit_numerics::{
    check::Fault,
    words::{Shown, counted},
};
use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::fault;
use crate::spec::{
    Contamination, DEFAULT_COVERAGE, DEFAULT_K2, DEFAULT_SHARE, Distribution, LEstimator, MEstimator, QuantileWeights,
    Start,
};

/// Largest integer that every JSON client can hold.
const MOST_SEED: u64 = (1 << 53) - 1;

/// Estimator of the coefficients; default `least_squares`. Weights of nodes multiply squared
/// residuals for every estimator: rows and heights are scaled by √weight.
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub(in crate::spec) enum Estimator {
    /// Least squares, the default.
    LeastSquares {},
    /// Least Σρ(r/s) by iteratively reweighted least squares (Eqs. 10–12); regularisation and
    /// diagnostics act on the weighted matrix.
    #[serde(rename = "m_estimator")]
    M {
        loss: Loss,
        /// In units of the scale: k of Huber (default 1.345), c of Tukey (4.685), a, b, c of Hampel
        /// (2, 4, 8), a of Andrews (1.339).
        #[serde(skip_serializing_if = "Option::is_none")]
        #[schema(min_items = 1, max_items = 3, example = json!([1.345]))]
        tuning: Option<Vec<f64>>,
        /// For `huber`, instead of `tuning`: the share ε of gross errors, which gives the minimax k
        /// (Eq. 10), or `estimate`: the ε of the least favourable distribution that maximises the
        /// likelihood of the residuals.
        #[serde(skip_serializing_if = "Option::is_none")]
        contamination: Option<Contamination>,
        #[serde(default)]
        scale: Scale,
        /// The iteration ends when no residual and not the scale moves by more than this many
        /// scales.
        #[serde(default = "tolerance")]
        #[schema(exclusive_minimum = 0, maximum = 0.1, default = json!(MEstimator::TOLERANCE))]
        tolerance: f64,
        /// Most iterations.
        #[serde(default = "iterations")]
        #[schema(minimum = 1, maximum = 10000, default = json!(MEstimator::ITERATIONS))]
        max_iterations: usize,
        /// Default `least_squares`.
        #[serde(default)]
        start: Start,
    },
    /// Least Σ|r|, solved exactly, with a certificate of optimality.
    LeastAbsoluteDeviations {},
    /// Least Σ|r|^p.
    Lp {
        /// Power p of the minimised sum Σ|r|^p: 1 is least absolute deviations, 2 least squares.
        #[schema(minimum = 1, maximum = 2)]
        p: f64,
    },
    /// Regression quantile: a share `tau` of the nodes lies below the surface.
    Quantile {
        /// Share of the nodes below the surface, between 0 and 1; 0.5 is the median.
        #[schema(exclusive_minimum = 0, exclusive_maximum = 1)]
        tau: f64,
    },
    /// Least sum of the h smallest squares (FAST-LTS; every subset is tried where there are few).
    LeastTrimmedSquares {
        /// Share of nodes in the sum: h = ⌊coverage·m⌋, at least ⌊(m + n + 1)/2⌋.
        #[serde(default = "coverage")]
        #[schema(minimum = 0.5, maximum = 1, default = json!(DEFAULT_COVERAGE))]
        coverage: f64,
        /// Seed of the random starts; the same seed gives the same answer.
        #[serde(default)]
        #[schema(minimum = 0, maximum = 9007199254740991i64, default = 0)]
        seed: u64,
    },
    /// Least rank dispersion (Jaeckel), with Wilcoxon scores by a simplex method (with many ties it
    /// may stop before the minimum: `not_converged`); the constant is set by
    /// the median of the residuals.
    Rank {
        /// Default `wilcoxon`.
        #[serde(default)]
        scores: Scores,
    },
    /// Linear combinations of order statistics, by regression quantiles (Koenker and Bassett).
    #[serde(rename = "l_estimator")]
    L {
        form: LEstimatorForm,
        /// For `trimmed` and `winsorized`: share of the nodes at either end. By default 0.1.
        #[serde(skip_serializing_if = "Option::is_none")]
        #[schema(exclusive_minimum = 0, exclusive_maximum = 0.5)]
        share: Option<f64>,
        /// For `quantiles`, required there: τ of each, ascending.
        #[serde(skip_serializing_if = "Option::is_none")]
        #[schema(min_items = 1, max_items = 9, example = json!([0.25, 0.5, 0.75]))]
        quantiles: Option<Vec<f64>>,
        /// For `quantiles`, required there: the weight of each, summing to 1.
        #[serde(skip_serializing_if = "Option::is_none")]
        #[schema(min_items = 1, max_items = 9, example = json!([0.25, 0.5, 0.25]))]
        weights: Option<Vec<f64>>,
    },
    /// Greatest likelihood for errors that are not normal.
    MaximumLikelihood {
        distribution: DistributionName,
        /// ν of `student`, 0.5 to 200 (estimated from 4n/(m − n) on); p of `generalized_normal`,
        /// 1 to 8. Estimated by default. `laplace` has no shape.
        #[serde(skip_serializing_if = "Option::is_none")]
        #[schema(minimum = 0.5, maximum = 200)]
        shape: Option<f64>,
    },
}

/// Huber's is convex; the others give far nodes no weight at all and may have several local
/// solutions.
#[derive(Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::spec) enum Loss {
    Huber,
    Tukey,
    Hampel,
    Andrews,
}

/// The scale of residuals, recomputed in each iteration; default `mad_0_6745`.
#[skip_serializing_none]
#[derive(Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ResidualScale)]
pub(in crate::spec) struct Scale {
    rule: ScaleRule,
    /// `fixed`: the scale itself, in the unit of the heights (required). `proposal2`: k₂, default
    /// 1.345. Not for other rules.
    #[schema(exclusive_minimum = 0)]
    value: Option<f64>,
}

/// MAD about 0 divided by 0.6745 or by Φ⁻¹(0.75), Huber's proposal 2, or the caller's.
#[derive(Clone, Copy, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::spec) enum ScaleRule {
    #[default]
    #[serde(rename = "mad_0_6745")]
    Mad06745,
    Mad,
    Proposal2,
    Fixed,
}

/// Scores of ranks: `wilcoxon` i/(m + 1) − 1/2, `normal` (van der Waerden) Φ⁻¹(i/(m + 1)).
#[derive(Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::spec) enum Scores {
    #[default]
    Wilcoxon,
    Normal,
}

/// Nodes outside two regression quantiles left out (`trimmed`), or moved to them (`winsorized`);
/// several regression quantiles with weights (`quantiles`).
#[derive(Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::spec) enum LEstimatorForm {
    Trimmed,
    Winsorized,
    Quantiles,
}

/// The distribution of the errors; `generalized_normal` has the density exp(−(|r|/a)^p), up to a
/// factor.
#[derive(Clone, Copy, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::spec) enum DistributionName {
    Student,
    Laplace,
    GeneralizedNormal,
}

fn tolerance() -> f64 {
    MEstimator::TOLERANCE
}

fn iterations() -> usize {
    MEstimator::ITERATIONS
}

fn coverage() -> f64 {
    DEFAULT_COVERAGE
}

impl TryFrom<Estimator> for super::super::Estimator {
    type Error = Fault;

    fn try_from(estimator: Estimator) -> Result<Self, Fault> {
        Ok(match estimator {
            Estimator::LeastSquares {} => Self::LeastSquares,
            Estimator::M { loss, tuning, contamination, scale, tolerance, max_iterations, start } => {
                let loss = match (contamination, tuning) {
                    (Some(_), _) if loss != Loss::Huber => {
                        return Err(fault("contamination", "only the loss `huber` takes it"));
                    }
                    (Some(_), Some(_)) => {
                        let message = "the tuning constant follows from it: give one of both";
                        return Err(fault("contamination", message));
                    }
                    (Some(contamination), None) => MEstimator::minimax(contamination).loss,
                    (None, Some(tuning)) => tuned(loss, &tuning)?,
                    (None, None) => loss.usual(),
                };
                Self::M(MEstimator { loss, scale: scale.rule()?, tolerance, max_iterations, start, contamination })
            }
            Estimator::LeastAbsoluteDeviations {} => Self::LeastAbsolute,
            Estimator::Lp { p } => Self::Lp { p },
            Estimator::Quantile { tau } => Self::Quantile { tau },
            Estimator::LeastTrimmedSquares { seed, .. } if seed > MOST_SEED => {
                return Err(fault("seed", format_args!("{seed} is greater than {MOST_SEED}")));
            }
            Estimator::LeastTrimmedSquares { coverage, seed } => Self::LeastTrimmed { coverage, seed },
            Estimator::Rank { scores: Scores::Wilcoxon } => Self::Rank,
            Estimator::Rank { scores: Scores::Normal } => Self::NormalScores,
            Estimator::L { form, share, quantiles, weights } => Self::L(l_estimator(form, share, quantiles, weights)?),
            Estimator::MaximumLikelihood { distribution, shape } => Self::Likelihood(likelihood(distribution, shape)?),
        })
    }
}

impl Loss {
    /// The loss with its default tuning.
    fn usual(self) -> crate::spec::Loss {
        match self {
            Loss::Huber => crate::spec::Loss::HUBER,
            Loss::Tukey => crate::spec::Loss::TUKEY,
            Loss::Hampel => crate::spec::Loss::HAMPEL,
            Loss::Andrews => crate::spec::Loss::ANDREWS,
        }
    }
}

fn tuned(loss: Loss, tuning: &[f64]) -> Result<crate::spec::Loss, Fault> {
    if let Some((i, value)) = tuning.iter().enumerate().find(|(_, value)| **value <= 0.0) {
        return Err(fault(&format!("tuning[{i}]"), format_args!("{} is not greater than 0", Shown(*value))));
    }
    let constants = counted(tuning.len(), "constant", "constants");
    match (loss, tuning) {
        (Loss::Huber, &[k]) => Ok(crate::spec::Loss::Huber { k }),
        (Loss::Tukey, &[c]) => Ok(crate::spec::Loss::Tukey { c }),
        (Loss::Andrews, &[a]) => Ok(crate::spec::Loss::Andrews { a }),
        (Loss::Hampel, &[a, b, c]) if a <= b && b < c => Ok(crate::spec::Loss::Hampel { a, b, c }),
        (Loss::Hampel, &[a, b, c]) => {
            let values = format!("{}, {}, {}", Shown(a), Shown(b), Shown(c));
            Err(fault("tuning", format_args!("{values} do not ascend: a ≤ b < c is needed")))
        }
        (Loss::Hampel, _) => Err(fault("tuning", format_args!("{constants}; hampel has three, a ≤ b < c"))),
        _ => Err(fault("tuning", format_args!("{constants}; this loss has one"))),
    }
}

impl Scale {
    fn rule(&self) -> Result<crate::spec::ScaleRule, Fault> {
        let [low, high] = crate::spec::ScaleRule::K2;
        match (self.rule, self.value) {
            (ScaleRule::Mad06745, None) => Ok(crate::spec::ScaleRule::Mad06745),
            (ScaleRule::Mad, None) => Ok(crate::spec::ScaleRule::Mad),
            (ScaleRule::Mad06745 | ScaleRule::Mad, Some(_)) => {
                Err(fault("scale.value", "only the rules `fixed` and `proposal2` take a value"))
            }
            (ScaleRule::Proposal2, Some(k2)) if !(low <= k2 && k2 <= high) => {
                let message = format!("k₂ = {} is not between {} and {}", Shown(k2), Shown(low), Shown(high));
                Err(fault("scale.value", message))
            }
            (ScaleRule::Proposal2, k2) => Ok(crate::spec::ScaleRule::Proposal2 { k2: k2.unwrap_or(DEFAULT_K2) }),
            (ScaleRule::Fixed, Some(value)) => Ok(crate::spec::ScaleRule::Fixed(value)),
            (ScaleRule::Fixed, None) => Err(fault("scale.value", "missing; required by the rule `fixed`")),
        }
    }
}

fn l_estimator(
    form: LEstimatorForm,
    share: Option<f64>,
    quantiles: Option<Vec<f64>>,
    weights: Option<Vec<f64>>,
) -> Result<LEstimator, Fault> {
    let combined = form == LEstimatorForm::Quantiles;
    for (name, is_given) in [("quantiles", quantiles.is_some()), ("weights", weights.is_some())] {
        if is_given && !combined {
            return Err(fault(name, "only the form `quantiles` takes it"));
        }
        if !is_given && combined {
            return Err(fault(name, "missing; the form `quantiles` needs it"));
        }
    }
    if combined && share.is_some() {
        return Err(fault("share", "only the forms `trimmed` and `winsorized` take it"));
    }
    let share = share.unwrap_or(DEFAULT_SHARE);
    match form {
        LEstimatorForm::Trimmed => Ok(LEstimator::Trimmed { share }),
        LEstimatorForm::Winsorized => Ok(LEstimator::Winsorized { share }),
        LEstimatorForm::Quantiles => {
            let (quantiles, weights) = (quantiles.unwrap_or_default(), weights.unwrap_or_default());
            combination(&quantiles, &weights).map(LEstimator::Quantiles)
        }
    }
}

fn combination(taus: &[f64], weights: &[f64]) -> Result<QuantileWeights, Fault> {
    if taus.len() != weights.len() {
        return Err(fault("weights", format_args!("{} weights for {} quantiles", weights.len(), taus.len())));
    }
    for (i, tau) in taus.iter().enumerate() {
        let place = || format!("quantiles[{i}]");
        if !(*tau > 0.0 && *tau < 1.0) {
            return Err(fault(&place(), format_args!("{} is not between 0 and 1", Shown(*tau))));
        }
        if i > 0 && *tau <= taus[i - 1] {
            return Err(fault(&place(), format_args!("{} is not above the one before", Shown(*tau))));
        }
    }
    let pairs: Vec<[f64; 2]> = taus.iter().zip(weights).map(|(tau, weight)| [*tau, *weight]).collect();
    QuantileWeights::new(&pairs).ok_or_else(|| {
        let sum: f64 = weights.iter().sum();
        fault("weights", format_args!("the weights add up to {}, not to 1", Shown(sum)))
    })
}

fn likelihood(name: DistributionName, shape: Option<f64>) -> Result<Distribution, Fault> {
    let ([low, high], distribution) = match name {
        DistributionName::Student => (Distribution::FREEDOM, Distribution::Student { freedom: shape }),
        DistributionName::GeneralizedNormal => {
            (Distribution::EXPONENT, Distribution::GeneralizedNormal { exponent: shape })
        }
        DistributionName::Laplace if shape.is_some() => {
            return Err(fault("shape", "the distribution `laplace` takes none"));
        }
        DistributionName::Laplace => return Ok(Distribution::Laplace),
    };
    match shape.filter(|shape| !(low <= *shape && *shape <= high)) {
        None => Ok(distribution),
        Some(shape) => Err(fault("shape", format_args!("{} is not between {low} and {high}", Shown(shape)))),
    }
}

impl From<super::super::Estimator> for Estimator {
    fn from(estimator: super::super::Estimator) -> Self {
        match estimator {
            super::super::Estimator::LeastSquares => Estimator::LeastSquares {},
            super::super::Estimator::M(m) => m.into(),
            super::super::Estimator::LeastAbsolute => Estimator::LeastAbsoluteDeviations {},
            super::super::Estimator::Lp { p } => Estimator::Lp { p },
            super::super::Estimator::Quantile { tau } => Estimator::Quantile { tau },
            super::super::Estimator::LeastTrimmed { coverage, seed } => {
                Estimator::LeastTrimmedSquares { coverage, seed }
            }
            super::super::Estimator::Rank => Estimator::Rank { scores: Scores::Wilcoxon },
            super::super::Estimator::NormalScores => Estimator::Rank { scores: Scores::Normal },
            super::super::Estimator::L(combination) => {
                let (form, share) = match combination {
                    LEstimator::Trimmed { share } => (LEstimatorForm::Trimmed, Some(share)),
                    LEstimator::Winsorized { share } => (LEstimatorForm::Winsorized, Some(share)),
                    LEstimator::Quantiles(pairs) => {
                        let part = |at: usize| Some(pairs.pairs().iter().map(|pair| pair[at]).collect());
                        let (form, share) = (LEstimatorForm::Quantiles, None);
                        return Estimator::L { form, share, quantiles: part(0), weights: part(1) };
                    }
                };
                Estimator::L { form, share, quantiles: None, weights: None }
            }
            super::super::Estimator::Likelihood(distribution) => {
                let (distribution, shape) = match distribution {
                    Distribution::Student { freedom } => (DistributionName::Student, freedom),
                    Distribution::Laplace => (DistributionName::Laplace, None),
                    Distribution::GeneralizedNormal { exponent } => (DistributionName::GeneralizedNormal, exponent),
                };
                Estimator::MaximumLikelihood { distribution, shape }
            }
        }
    }
}

impl From<MEstimator> for Estimator {
    fn from(m: MEstimator) -> Self {
        let (loss, tuning) = match m.loss {
            crate::spec::Loss::Huber { k } => (Loss::Huber, vec![k]),
            crate::spec::Loss::Tukey { c } => (Loss::Tukey, vec![c]),
            crate::spec::Loss::Hampel { a, b, c } => (Loss::Hampel, vec![a, b, c]),
            crate::spec::Loss::Andrews { a } => (Loss::Andrews, vec![a]),
        };
        let (rule, value) = match m.scale {
            crate::spec::ScaleRule::Mad06745 => (ScaleRule::Mad06745, None),
            crate::spec::ScaleRule::Mad => (ScaleRule::Mad, None),
            crate::spec::ScaleRule::Proposal2 { k2 } => (ScaleRule::Proposal2, Some(k2)),
            crate::spec::ScaleRule::Fixed(value) => (ScaleRule::Fixed, Some(value)),
        };
        Estimator::M {
            loss,
            tuning: m.contamination.is_none().then_some(tuning),
            contamination: m.contamination,
            scale: Scale { rule, value },
            tolerance: m.tolerance,
            max_iterations: m.max_iterations,
            start: m.start,
        }
    }
}
