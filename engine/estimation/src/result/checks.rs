//! Warnings of the checks of residuals.

use super::{Warning, fit_result::FitResult, words::Probability};
use crate::{inference::Doubts, spec::Along};
use flankfit_numerics::{
    warnings,
    words::{Size, listed, rounded},
};

/// Probability below which one check alone casts doubt on intervals.
const CERTAIN: f64 = 0.001;

warnings! {
/// Assumption that the residuals contradict.
pub enum ResidualWarning {
    /// Residuals that are correlated with their neighbours.
    #[error(
        "the residuals are correlated{}: {correlation:.2} between neighbours, which independent errors have with a \
         probability of {}. Either the model is incomplete, or the errors are correlated, and standard errors that \
         assume independence are too small by a factor of about {factor:.1}; raise the degree{}",
        .along.map_or_else(String::new, |along| format!(" along {}", along.name())), Probability(*.p),
        match (.along, .model) {
            (None, _) => ", or request `errors` with the `line` of each node".to_owned(),
            (Some(_), Some(model)) => format!(", or request `errors` along {}", model.name()),
            (Some(_), None) => String::new(),
        }
    )]
    "correlated_residuals" => CorrelatedResiduals {
        /// Direction of the scan lines; absent for scattered nodes.
        along: Option<Along>,
        /// Direction of a model of the errors that has this correlation.
        model: Option<Along>,
        /// `Σ rᵢrᵢ₊₁ / Σ r²` over neighbours.
        correlation: f64,
        /// The probability that residuals of independent errors are so correlated.
        p: f64,
        /// Factor by which the standard errors are too small.
        factor: f64,
    },
    /// A variance of the errors that depends on the place.
    #[error(
        "the residuals are larger {} than elsewhere, which errors of one variance are with a probability of {}: \
         intervals and bands where they are larger are too narrow by a factor of up to about {factor:.1}, elsewhere \
         too wide; request `variance` `hc3` or `power_of` the coordinate",
        larger.along(*.along), Probability(*.p)
    )]
    "uneven_variance" => UnevenVariance {
        /// The axis along which the variance changes.
        along: Along,
        /// Part of the axis with the larger errors.
        larger: LargerErrors,
        /// The probability that errors of one variance seem so uneven.
        p: f64,
        /// Factor by which standard errors of heights are too small at the worst place.
        factor: f64,
    },
    /// A shape of the residuals that the model lacks.
    #[error(
        "the residuals have a shape that the model lacks ({}{}), which noise has with a probability of {}: no interval \
         or band includes it, and those of heights are too narrow by a factor of about {factor:.1}; raise the degree, \
         add terms or take splines",
        .shape.words(), .rms.map_or_else(String::new, |rms| format!(", with an rms of about {} at the nodes", Size(rms))),
        Probability(*.p)
    )]
    "lack_of_fit" => LackOfFit {
        /// Shape of the residuals.
        shape: MissingShape,
        /// Root mean square of the shape at the nodes, in heights of weight 1; absent with
        /// `errors`, which make the residuals white.
        rms: Option<f64>,
        /// The probability that noise has such a shape.
        p: f64,
        /// Factor by which standard errors of heights are too small at the nodes on average.
        factor: f64,
    },
    /// Nodes of low weight that lie together.
    #[error(
        "{count} nodes ({:.0} %) have less than half their weight, and they lie together near {}: {pairs} pairs \
         of neighbours, where as many nodes at random have {expected_pairs:.1}. The fit does not follow the surface \
         there: intervals and bands do not include its distance from these nodes, {} on average; look for a region \
         that was measured wrongly, or a shape that the model lacks",
        100.0 * .share, listed(.place.iter().map(|x| rounded(*x, 4))), Size(*.residual)
    )]
    "clustered_low_weights" => ClusteredLowWeights {
        /// Nodes with less than half their weight.
        count: usize,
        /// Their share of the counted nodes.
        share: f64,
        /// Pairs of neighbours among them.
        pairs: usize,
        /// The number of pairs that is expected of as many nodes at random.
        expected_pairs: f64,
        /// The probability of so many pairs at random.
        p: f64,
        /// Mean place of those with such a neighbour: u and v, or x of a curve.
        place: Vec<f64>,
        /// Their mean residual.
        residual: f64,
    },
}
}

impl ResidualWarning {
    /// The probability that errors as assumed fail the check so clearly.
    fn p(&self) -> f64 {
        match *self {
            ResidualWarning::CorrelatedResiduals { p, .. }
            | ResidualWarning::UnevenVariance { p, .. }
            | ResidualWarning::LackOfFit { p, .. }
            | ResidualWarning::ClusteredLowWeights { p, .. } => p,
        }
    }
}

impl FitResult {
    /// Returns the warnings that intervals may not hold. A single check of the residuals counts
    /// only if it is certain.
    pub fn doubts(&self) -> Doubts {
        let check = |warning: &Warning| match warning {
            Warning::Residuals { warning } => Some(warning.p()),
            _ => None,
        };
        let several = self.warnings.iter().filter_map(check).count() > 1;
        let counts = |warning: &&Warning| several || check(warning).is_none_or(|p| p < CERTAIN);
        self.warnings.iter().filter(counts).map(Warning::code).collect()
    }

    /// Returns the result with its doubts in its intervals.
    pub(crate) fn with_doubts(mut self) -> Self {
        let doubts = self.doubts();
        let intervals = self.coefficients.iter_mut().filter_map(|one| one.interval.as_mut());
        let of_sums = self.sums.iter_mut().flatten().flatten().filter_map(|one| one.interval.as_mut());
        intervals.chain(of_sums).for_each(|interval| interval.about.doubts = doubts);
        self
    }
}

impl From<ResidualWarning> for Warning {
    fn from(warning: ResidualWarning) -> Self {
        Warning::Residuals { warning }
    }
}

/// Place along an axis where errors are larger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum LargerErrors {
    /// Towards both ends.
    Ends,
    /// In the middle.
    Middle,
    /// Towards the upper end.
    High,
    /// Towards the lower end.
    Low,
}

impl LargerErrors {
    pub(super) fn along(self, along: Along) -> String {
        let name = if along == Along::Order { "x" } else { along.name() };
        match self {
            LargerErrors::Ends => format!("at both ends of {name}"),
            LargerErrors::Middle => format!("in the middle of {name}"),
            LargerErrors::High => format!("towards large {name}"),
            LargerErrors::Low => format!("towards small {name}"),
        }
    }
}

/// Shape that a model lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum MissingShape {
    /// Terms of the next order.
    NextOrder,
    /// A smooth function that is not a sum of those.
    Smooth,
}

impl MissingShape {
    pub(super) fn words(self) -> &'static str {
        match self {
            MissingShape::NextOrder => "terms of the next degree",
            MissingShape::Smooth => "smooth, of higher degree",
        }
    }
}
