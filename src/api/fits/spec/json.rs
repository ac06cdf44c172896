//! A spec as JSON with every default filled in, for storing and for the digest.

use super::{
    filters::FilterBody,
    include::named,
    regularization_json::regularization,
    request::*,
    zeros::{unsigned_zero, unsigned_zeros},
};
use crate::api::json::writer::text_of;
use flankfit_engine::estimation::spec::{self, FitSpec};

/// The canonical JSON text: keys in the contract's order, defaults written out, no white space, −0
/// as 0.
pub fn to_json(spec: &FitSpec) -> String {
    text_of(&FitSpecBody::from(spec))
}

impl From<&FitSpec> for FitSpecBody {
    fn from(spec: &FitSpec) -> Self {
        FitSpecBody {
            model: model(&spec.model),
            fit: FitFields {
                scaling: Some(match spec.scaling {
                    spec::Scaling::UnitLength => ScalingName::UnitLength,
                    spec::Scaling::None => ScalingName::None,
                    spec::Scaling::Standardized => ScalingName::Standardized,
                }),
                regularization: Some(regularization(&spec.regularization)),
                estimator: Some(EstimatorBody::from(&spec.estimator)),
                coefficient_norm_limit: spec.coefficient_norm_limit,
                noise_sigma: spec.noise_sigma,
                node_uncertainty: spec.node_uncertainty.map(|uncertainty| NodeUncertaintyBody {
                    position: unsigned_zero(uncertainty.position),
                    height: unsigned_zero(uncertainty.height),
                }),
                errors: spec.errors.as_ref().map(ErrorsBody::from),
                variance: written(&spec.variance),
                level: Some(spec.level),
                include: named(spec.include),
                filters: (!spec.filters.is_empty()).then(|| spec.filters.iter().map(FilterBody::from).collect()),
            },
            domain: spec.domain.map(|domain| {
                let interval = |ends: [f64; 2]| ends.map(unsigned_zero);
                DomainBody { u: domain.u.map(interval), v: domain.v.map(interval) }
            }),
            prior: spec.prior.as_ref().map(PriorBody::from),
            predict: spec.predict.as_ref().map(PredictBody::from),
            select: spec.select.as_ref().map(SelectBody::from),
            folds: spec.folds.as_ref().map(FoldsBody::from),
        }
    }
}

fn model(model: &spec::Model) -> ModelBody {
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
