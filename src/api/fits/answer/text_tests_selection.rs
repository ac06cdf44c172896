//! What a fit may say of its nodes and of its model's selection, made up.

use super::Maker;
use flankfit_engine::estimation::{
    result::{Candidate, Influence, Selection},
    spec::{Degree, ModelCriterion},
};

impl Maker {
    pub(super) fn influence(&mut self) -> Influence {
        let list = |m: &mut Self| m.there().then(|| m.list(Maker::maybe));
        Influence {
            leverage: self.numbers(),
            internally_studentized: list(self),
            externally_studentized: list(self),
            cooks_distance: list(self),
            dffits: list(self),
            press_residual: self.list(Maker::maybe),
            press: self.maybe(),
            node_indices: self.there().then(|| vec![self.below(9)]),
        }
    }

    pub(super) fn selection(&mut self) -> Selection {
        Selection {
            criterion: ModelCriterion::ALL[self.below(5)],
            candidates: self.list(|m| Candidate {
                degree: m.there().then(|| [Degree::Both(7), Degree::Each(3, 0)][m.below(2)]),
                terms: m.there().then(|| vec![m.text()]),
                coefficients: m.below(99),
                lambda: m.maybe(),
                aic: m.maybe(),
                aicc: m.maybe(),
                bic: m.maybe(),
                press: m.maybe(),
                blocked_cv: m.maybe(),
                reml: m.maybe(),
                rss: m.number(),
                sigma: m.maybe(),
            }),
            chosen: self.below(9),
        }
    }
}
