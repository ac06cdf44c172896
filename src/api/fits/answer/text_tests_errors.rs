//! What a fit may say of residuals, and of errors that are not white, made up.

use super::Maker;
use flankfit_engine::estimation::{
    result::{ErrorsReport, PositionsReport, ResidualReport, VarianceReport},
    spec::{Along, Correlation, PositionKind},
};

impl Maker {
    pub(super) fn residuals(&mut self) -> ResidualReport {
        ResidualReport {
            count: self.below(1_000_000_000),
            degrees_of_freedom: self.below(9),
            rss: self.number(),
            sigma: self.maybe(),
            rms: self.number(),
            max_abs: self.maybe(),
            r_squared: self.maybe(),
            least_squares_rss: self.number(),
            values: self.there().then(|| self.numbers()),
            fitted: self.there().then(|| self.numbers()),
            heights: self.there().then(|| self.numbers()),
            node_indices: self.there().then(|| vec![0, self.below(1_000_000)]),
        }
    }

    pub(super) fn errors(&mut self) -> ErrorsReport {
        ErrorsReport {
            correlation: Correlation::Ar2 { phi: Some([0.5, -1e-3]) },
            along: Along::V,
            std_errors: self.there().then_some([0.25, 0.125]),
            effective_count: 12.5,
            whiteness: None,
            lags: self.below(11),
        }
    }

    pub(super) fn positions(&mut self) -> PositionsReport {
        PositionsReport {
            kind: if self.there() { PositionKind::Measured } else { PositionKind::Nominal },
            rounds: self.below(2000),
            variance_share: self.number(),
            largest_shift: self.number(),
            sigma_ratio: self.maybe(),
        }
    }

    pub(super) fn variance(&mut self) -> VarianceReport {
        VarianceReport::Groups(vec![(-3, 0.5), (self.below(9) as i64, 2.0)])
    }
}
