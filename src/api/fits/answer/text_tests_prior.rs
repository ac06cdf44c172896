//! What a fit may say of its prior, made up.

use super::Maker;
use flankfit_engine::estimation::result::{PriorConflict, PriorReport, UsedCorrection};

impl Maker {
    fn conflict(&mut self) -> PriorConflict {
        PriorConflict { statistic: self.number(), p: self.number(), let_go: false }
    }

    pub(super) fn prior(&mut self) -> PriorReport {
        PriorReport {
            iterations: self.there().then(|| vec![1, 2]),
            fit_ids: self.there().then(|| vec![self.text(), self.text()]),
            corrections: self.list(|m| UsedCorrection {
                iteration: 1,
                record_id: m.text(),
                // read from JSON, which has finite numbers only
                entered: m.there().then(|| vec![0.5, -2.0]),
            }),
            move_std_error: self.there().then(|| self.numbers()),
            move_ratio: self.maybe(),
            conflict: self.there().then(|| self.conflict()),
            share: self.numbers(),
            sigma: self.maybe(),
            degrees_of_freedom: self.there().then(|| self.below(99)),
        }
    }
}
