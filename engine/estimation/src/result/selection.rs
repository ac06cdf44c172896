//! Choice of one of several models, and the criteria of each.

use crate::spec::{Degree, ModelCriterion};

/// Selection of one of several models, with the figures of each.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct Selection {
    /// Criterion of the selection.
    pub criterion: ModelCriterion,
    /// All models compared: degrees ascending, that along v fastest; terms in the order in
    /// which they were removed (`backward`) or added (`elastic_net`).
    pub candidates: Vec<Candidate>,
    /// Index of the chosen one of `candidates`, from 0.
    pub chosen: usize,
}

/// A model by plain least squares; exactly one of `degree` and `terms` is present. Likelihoods are
/// those of normal errors with σ² at its maximum; σ² counts as a parameter: k is `coefficients` +
/// 1.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Candidate {
    /// Degree of a curve or of a total degree, or `[p, q]`.
    pub degree: Option<Degree>,
    /// Terms of the model, named as in `coefficients`.
    pub terms: Option<Vec<String>>,
    /// Number of coefficients n.
    pub coefficients: usize,
    /// λ of the elastic net that keeps these terms, in the unit of the heights; of several the
    /// one with the least `blocked_cv`.
    pub lambda: Option<f64>,
    /// Akaike's criterion, −2 ln L + 2k; absent, like everything derived from L, if the residuals
    /// are 0 up to rounding, or n = m.
    pub aic: Option<f64>,
    /// The same corrected for few nodes; absent where m ≤ k + 1.
    pub aicc: Option<f64>,
    /// Schwarz's criterion, −2 ln L + k ln m.
    pub bic: Option<f64>,
    /// Σ w r²/(1 − h)², unit of the heights squared; absent where a node has leverage 1.
    pub press: Option<f64>,
    /// Σ w r² of nodes left out in blocks, unit of the heights squared; with `elastic_net` that of
    /// its own estimates at `lambda`, recomputed without each block. Absent where the other nodes
    /// do not determine a block.
    pub blocked_cv: Option<f64>,
    /// −2 ln of the marginal likelihood with Zellner's prior, without the part that all models
    /// have in common; absent where `aic` is.
    pub reml: Option<f64>,
    /// Σ w r², unit of the heights squared.
    pub rss: f64,
    /// √(rss/(m − n)), unit of the heights; absent without degrees of freedom.
    pub sigma: Option<f64>,
}

impl Selection {
    /// True if every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.candidates.iter().all(|c| {
            let maybe = [c.lambda, c.aic, c.aicc, c.bic, c.press, c.blocked_cv, c.reml, c.sigma];
            c.rss.is_finite() && maybe.into_iter().flatten().all(f64::is_finite)
        })
    }
}

impl Candidate {
    /// Value of `criterion`, which the choice minimises; `None` if it does not exist.
    pub fn figure(&self, criterion: ModelCriterion) -> Option<f64> {
        match criterion {
            ModelCriterion::Aicc => self.aicc,
            ModelCriterion::Bic => self.bic,
            ModelCriterion::Press => self.press,
            ModelCriterion::BlockedCv => self.blocked_cv,
            ModelCriterion::Reml => self.reml,
        }
    }
}
