//! Which of several models was fitted, and what speaks for each.

use crate::spec::{Degree, ModelCriterion};

/// Which of several models was fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// By what.
    pub criterion: ModelCriterion,
    /// Every model that was looked at: degrees ascending, that along v running fastest; terms in
    /// the order in which they were let go, or came in along the path of the elastic net.
    pub candidates: Vec<Candidate>,
    /// Which of them was fitted.
    pub chosen: usize,
}

/// A model by plain least squares. Likelihoods are those of normal errors with σ² at its maximum; a
/// figure that does not exist is `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Degree along u and v, or that of a curve; of candidates that are degrees.
    pub degree: Option<Degree>,
    /// Its terms, of candidates that are subsets of terms.
    pub terms: Option<Vec<String>>,
    /// n.
    pub coefficients: usize,
    /// λ of the elastic net that kept these terms; of several the one with the least `blocked_cv`.
    pub lambda: Option<f64>,
    /// −2 ln L + 2(n + 1), σ² counted as a parameter; `None`, like all that is made of L, where the
    /// residuals are 0 but for rounding, or n = m.
    pub aic: Option<f64>,
    /// `aic` corrected for few nodes.
    pub aicc: Option<f64>,
    /// −2 ln L + (n + 1) ln m.
    pub bic: Option<f64>,
    /// Σ w r²/(1 − h)²; `None` where a node has leverage 1.
    pub press: Option<f64>,
    /// Σ w r² of nodes that were left out in blocks; of the elastic net that of its own estimates
    /// at `lambda`, made anew without each block.
    pub blocked_cv: Option<f64>,
    /// −2 ln of the marginal likelihood, less what is the same for all candidates.
    pub reml: Option<f64>,
    /// Σ w r².
    pub rss: f64,
    /// √(rss/(m − n)).
    pub sigma: Option<f64>,
}

impl Selection {
    /// Whether every number is one.
    pub(crate) fn is_finite(&self) -> bool {
        self.candidates.iter().all(|c| {
            let maybe = [c.lambda, c.aic, c.aicc, c.bic, c.press, c.blocked_cv, c.reml, c.sigma];
            c.rss.is_finite() && maybe.into_iter().flatten().all(f64::is_finite)
        })
    }
}

impl Candidate {
    /// What `criterion` makes least.
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
