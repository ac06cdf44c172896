//! The model of a request: wire parts to checked values.

use crate::api::{
    faults::Faults,
    fits::spec::{
        knots::{KnotsBody, WeightsBody},
        model::*,
        zeros::unsigned_zeros,
    },
    json::{
        tags::{read_tag, unknown_type},
        value::read_value,
    },
    shapes::degree::{DegreeBody, SpansBody},
};
use flankfit_engine::{estimation::spec, words::counted};

/// The models that there are.
const MODELS: &str = "polynomial, b_spline and linear are";

/// The model that stands at `at`.
pub fn model(slice: &[u8], at: &str, faults: &mut Faults) -> Option<spec::Model> {
    match read_tag(slice, at, MODELS, faults)?.as_str() {
        "polynomial" => {
            let model: PolynomialModel = read_value(slice, at, faults)?;
            Some(spec::Model::Polynomial {
                degree: degree(model.degree),
                basis: match model.basis {
                    None | Some(BasisName::Monomial) => spec::PolynomialBasis::Monomial,
                    Some(BasisName::Chebyshev) => spec::PolynomialBasis::Chebyshev,
                    Some(BasisName::Legendre) => spec::PolynomialBasis::Legendre,
                },
                terms: model.terms.map_or(spec::Terms::Tensor, spec::Terms::from),
            })
        }
        "b_spline" => {
            let model: BSplineModel = read_value(slice, at, faults)?;
            let knots = match (model.knots, model.spans) {
                (Some(KnotsBody::Curve(knots)), None) => spec::Knots::Curve(unsigned_zeros(&knots)),
                (Some(KnotsBody::Surface([u, v])), None) => {
                    spec::Knots::Surface(unsigned_zeros(&u), unsigned_zeros(&v))
                }
                (None, Some(SpansBody::Both(n))) => spec::Knots::Spans(n),
                (None, Some(SpansBody::Each([a, b]))) => spec::Knots::SpansEach(a, b),
                (Some(_), Some(_)) => {
                    faults.push(format!("{at}/spans"), "give either `knots` or `spans`, not both");
                    return None;
                }
                (None, None) => {
                    faults.push(at, "give `knots` or `spans`");
                    return None;
                }
            };
            let weights = match model.weights {
                None => None,
                Some(WeightsBody::Curve(weights)) => Some(weights),
                Some(WeightsBody::Surface(rows)) => Some(flat_weights(&rows, at, faults)?),
            };
            Some(spec::Model::BSpline { degree: degree(model.degree), knots, weights })
        }
        "linear" => read_value::<LinearModel>(slice, at, faults).map(|_| spec::Model::Linear),
        other => {
            unknown_type(at, other, MODELS, faults);
            None
        }
    }
}

/// Rows of one length, end to end.
fn flat_weights(rows: &[Vec<f64>], at: &str, faults: &mut Faults) -> Option<Vec<f64>> {
    let before = faults.count();
    let columns = rows.first().map_or(0, Vec::len);
    for (i, row) in rows.iter().enumerate().filter(|(_, row)| row.len() != columns) {
        faults.push(
            format!("{at}/weights/{i}"),
            format!("{}, where the first row has {columns}", counted(row.len(), "weight", "weights")),
        );
    }
    (faults.count() == before).then(|| rows.concat())
}

fn degree(degree: DegreeBody) -> spec::Degree {
    match degree {
        DegreeBody::Both(n) => spec::Degree::Both(n),
        DegreeBody::Each([p, q]) => spec::Degree::Each(p, q),
    }
}
