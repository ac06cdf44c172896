//! A model as JSON with every default filled in.

use super::{
    knots::{KnotsBody, WeightsBody},
    model::*,
    terms::TermsBody,
    zeros::unsigned_zeros,
};
use crate::api::shapes::degree::{DegreeBody, SpansBody};
use flankfit_engine::estimation::spec;

/// The model with every default filled in.
pub fn model(model: &spec::Model) -> ModelBody {
    match model {
        spec::Model::Polynomial { degree, basis, terms } => ModelBody::Polynomial(PolynomialModel {
            kind: PolynomialTag::Polynomial,
            degree: degree_body(*degree),
            basis: Some(match basis {
                spec::PolynomialBasis::Monomial => BasisName::Monomial,
                spec::PolynomialBasis::Chebyshev => BasisName::Chebyshev,
                spec::PolynomialBasis::Legendre => BasisName::Legendre,
            }),
            terms: Some(TermsBody::from(terms)),
        }),
        spec::Model::BSpline { degree, knots, weights } => {
            let weights = weights.as_ref().map(|weights| match columns(*degree, knots) {
                // Without knots the curve and the surface of one row look alike; either way back
                // gives the same weights.
                None => WeightsBody::Curve(weights.clone()),
                Some(columns) => WeightsBody::Surface(weights.chunks(columns).map(<[f64]>::to_vec).collect()),
            });
            let (knots, spans) = match knots {
                spec::Knots::Curve(knots) => (Some(KnotsBody::Curve(unsigned_zeros(knots))), None),
                spec::Knots::Surface(u, v) => (Some(KnotsBody::Surface([unsigned_zeros(u), unsigned_zeros(v)])), None),
                spec::Knots::Spans(n) => (None, Some(SpansBody::Both(*n))),
                spec::Knots::SpansEach(a, b) => (None, Some(SpansBody::Each([*a, *b]))),
            };
            ModelBody::BSpline(BSplineModel {
                kind: BSplineTag::BSpline,
                degree: degree_body(*degree),
                knots,
                spans,
                weights,
            })
        }
        spec::Model::Linear => ModelBody::Linear(LinearModel { kind: LinearTag::Linear }),
    }
}

/// How many functions there are along v, where the knots say that there is a v.
fn columns(degree: spec::Degree, knots: &spec::Knots) -> Option<usize> {
    let q = match degree {
        spec::Degree::Both(q) | spec::Degree::Each(_, q) => q,
    };
    match knots {
        spec::Knots::Surface(_, v) => v.len().checked_sub(q.saturating_add(1)).filter(|columns| *columns > 0),
        spec::Knots::SpansEach(_, spans) => spans.checked_add(q),
        spec::Knots::Curve(_) | spec::Knots::Spans(_) => None,
    }
}

fn degree_body(degree: spec::Degree) -> DegreeBody {
    match degree {
        spec::Degree::Both(n) => DegreeBody::Both(n),
        spec::Degree::Each(p, q) => DegreeBody::Each([p, q]),
    }
}
