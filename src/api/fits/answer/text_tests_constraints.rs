//! What a fit may say of constraints and of the matrix B, made up.

use super::Maker;
use flankfit_engine::estimation::{
    result::{ActivePlace, ConstraintReport, ConstraintsReport, MatrixBFactors, ProductOfB, RepresentativeReport},
    spec::{ConstraintKind, Domain, FilterAxis, Model, Piece, PieceOf, Scheme},
};

impl Maker {
    fn constraint(&mut self) -> ConstraintReport {
        use ConstraintKind::*;
        ConstraintReport {
            kind: [Increasing, Decreasing, Convex, Concave][self.below(4)],
            along: [FilterAxis::U, FilterAxis::V][self.below(2)],
            domain: Domain { u: Some([self.number(), self.number()]), v: self.there().then_some([0.0, 1.0]) },
            least_value: self.number(),
            least_squares_least_value: self.number(),
            active: self.list(|m| ActivePlace { u: m.number(), v: m.maybe(), multiplier: m.number() }),
        }
    }

    pub(super) fn constraints(&mut self) -> ConstraintsReport {
        ConstraintsReport {
            constraints: self.list(Maker::constraint),
            rss: self.number(),
            rss_bound: self.number(),
            stationarity: self.number(),
            rounds: self.below(99),
        }
    }

    pub(super) fn piece(&mut self) -> Piece {
        Piece {
            model: Model::Linear,
            domain: self.there().then(|| Domain { u: Some([self.number(), 1.0]), v: None }),
            scheme: [Scheme::FirstOrder, Scheme::Exact][self.below(2)],
            lambda_star: self.number(),
            eigenvalues: self.numbers(),
            directions: self.rows(),
            scale: self.numbers(),
        }
    }

    pub(super) fn representative(&mut self) -> RepresentativeReport {
        let of = PieceOf { iteration: self.there().then_some(3), fit_id: self.there().then(|| self.text()) };
        RepresentativeReport { of, alignment: self.number() }
    }

    pub(super) fn factors(&mut self) -> MatrixBFactors {
        MatrixBFactors {
            e: self.number(),
            products: self.list(|m| ProductOfB {
                eigenvalue: m.number(),
                mu: m.number(),
                q: m.numbers(),
                s: m.numbers(),
            }),
            largest_eigenvalue: self.number(),
            largest_eigenvalue_bound: self.number(),
            mixed_eigenvalue: self.number(),
            mixed_eigenvalue_bound: self.number(),
        }
    }
}
