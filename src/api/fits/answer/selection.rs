//! Which of several models was fitted, as it is answered.

use super::declare::{FieldsAs, ListAs, WriteAs, answer, names};
use crate::api::json::writer::Object;
use flankfit_engine::estimation::{
    result::{Candidate, Selection},
    spec::{Degree, Include, ModelCriterion},
};

answer! {
    /// Selection of one of several models, with the figures of each.
    #[schema(as = Selection)]
    pub struct SelectionBody from Selection { criterion, candidates, chosen } {
        /// Criterion of the selection.
        criterion: SelectedBy = criterion,
        /// All models compared: degrees ascending, that along v fastest; terms in the order in
        /// which they were removed (`backward`) or added (`elastic_net`).
        candidates: Vec<CandidateBody> = candidates,
        /// Which of `candidates` was fitted, from 0.
        chosen: usize = chosen,
        /// The model was chosen from the nodes it is fitted to: intervals and standard errors
        /// ignore this choice, and their coverage is lower than stated
        /// (docs/explanation/selection.md). Always true.
        post_selection: bool = true,
    }
}

answer! {
    /// A model by plain least squares; exactly one of `degree` and `terms` is there. Likelihoods
    /// are those of normal errors with σ² at its maximum; σ² counts as a parameter: k is
    /// `coefficients` + 1.
    #[schema(as = Candidate)]
    pub struct CandidateBody from Candidate {
        degree, terms, coefficients, lambda, aic, aicc, bic, press, blocked_cv, reml, rss, sigma,
    } {
        /// Degree of a curve or of a total degree, or `[p, q]`.
        degree?: Degree = degree,
        /// Terms of the model, named as in `coefficients`.
        terms?: Vec<String> = terms,
        /// Number of coefficients n.
        coefficients: usize = coefficients,
        /// λ of the elastic net that keeps these terms, in the unit of the heights; of several the
        /// one with the least `blocked_cv`.
        lambda?: f64 = lambda,
        /// Akaike's criterion, −2 ln L + 2k; absent, like all that is made of L, where the
        /// residuals are 0 but for rounding, or n = m.
        aic?: f64 = aic,
        /// The same corrected for few nodes; absent where m ≤ k + 1.
        aicc?: f64 = aicc,
        /// Schwarz's criterion, −2 ln L + k ln m.
        bic?: f64 = bic,
        /// Σ w r²/(1 − h)², unit of the heights squared; absent where a node has leverage 1.
        press?: f64 = press,
        /// Σ w r² of nodes left out in blocks, unit of the heights squared; with `elastic_net` that
        /// of its own estimates at `lambda`, made anew without each block. Absent where the other
        /// nodes do not determine a block.
        blocked_cv?: f64 = blocked_cv,
        /// −2 ln of the marginal likelihood with Zellner's prior, without the part that all models
        /// have in common; absent where `aic` is.
        reml?: f64 = reml,
        /// Σ w r², unit of the heights squared.
        rss: f64 = rss,
        /// √(rss/(m − n)), unit of the heights; absent without degrees of freedom.
        sigma?: f64 = sigma,
    }
}

names! {
    /// Criterion that the chosen model minimises.
    pub enum SelectedBy from ModelCriterion {
        Aicc = "aicc",
        Bic = "bic",
        Press = "press",
        BlockedCv = "blocked_cv",
        Reml = "reml",
    }
}

impl WriteAs<Degree> for Degree {
    fn write_as(&self, object: &mut Object<'_>, name: &'static str, _: &Include) {
        match *self {
            Degree::Both(p) => object.count(name, p),
            Degree::Each(p, q) => object.counts(name, &[p, q]),
        };
    }
}
