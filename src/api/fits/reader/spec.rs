//! Everything about a fit but the nodes: wire parts to a checked [`FitSpec`], with the contract's
//! defaults and ranges.

use super::fields;
use crate::api::{
    faults::Faults,
    fits::spec::{
        request::*,
        zeros::{unsigned_zero, unsigned_zeros},
    },
    json::{
        tags::{read_tag, unknown_type},
        value::{read_object, read_value},
    },
};
use flankfit_engine::{
    estimation::{FitSpec, spec},
    fault::words::{Shown, counted},
};

/// The models that there are.
const MODELS: &str = "polynomial, b_spline and linear are";

/// The spec, when none of its members has a fault.
pub fn read(members: &FitSpecMembers<'_>, faults: &mut Faults) -> Option<FitSpec> {
    let before = faults.count();
    let model = members.model.required_with(faults, |slice, _, faults| read_model(slice, faults));
    // The rest is looked at in any case: all faults are reported at once.
    let domain = members.domain.text().and_then(|slice| read_domain(slice, faults));
    let prior = members.prior.text().and_then(|slice| super::prior::read(slice, faults));
    let predict = members.predict.text().and_then(|slice| super::predict::read(slice, faults));
    let select = members.select.text().and_then(|slice| super::select::read(slice, faults));
    let folds = members.folds.text().and_then(|slice| super::folds::read(slice, faults));
    // a prior leaves nothing to be regularised
    let regularization = if prior.is_some() { spec::Regularization::None } else { spec::Regularization::default() };
    let fit = fields::of_model(&members.fit, model.unwrap_or(spec::Model::Linear), regularization, faults);
    fit.filter(|_| faults.count() == before).map(|fit| FitSpec { domain, prior, predict, select, folds, ..fit })
}

fn read_model(slice: &[u8], faults: &mut Faults) -> Option<spec::Model> {
    match read_tag(slice, "/model", MODELS, faults)?.as_str() {
        "polynomial" => {
            let model: PolynomialModel = read_value(slice, "/model", faults)?;
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
            let model: BSplineModel = read_value(slice, "/model", faults)?;
            let knots = match (model.knots, model.spans) {
                (Some(KnotsBody::Curve(knots)), None) => spec::Knots::Curve(unsigned_zeros(&knots)),
                (Some(KnotsBody::Surface([u, v])), None) => {
                    spec::Knots::Surface(unsigned_zeros(&u), unsigned_zeros(&v))
                }
                (None, Some(SpansBody::Both(n))) => spec::Knots::Spans(n),
                (None, Some(SpansBody::Each([a, b]))) => spec::Knots::SpansEach(a, b),
                (Some(_), Some(_)) => {
                    faults.push("/model/spans", "give either `knots` or `spans`, not both");
                    return None;
                }
                (None, None) => {
                    faults.push("/model", "give `knots` or `spans`");
                    return None;
                }
            };
            let weights = match model.weights {
                None => None,
                Some(WeightsBody::Curve(weights)) => Some(weights),
                Some(WeightsBody::Surface(rows)) => Some(flat_weights(&rows, faults)?),
            };
            Some(spec::Model::BSpline { degree: degree(model.degree), knots, weights })
        }
        "linear" => read_value::<LinearModel>(slice, "/model", faults).map(|_| spec::Model::Linear),
        other => {
            unknown_type("/model", other, MODELS, faults);
            None
        }
    }
}

/// Rows of one length, end to end.
fn flat_weights(rows: &[Vec<f64>], faults: &mut Faults) -> Option<Vec<f64>> {
    let before = faults.count();
    let columns = rows.first().map_or(0, Vec::len);
    for (i, row) in rows.iter().enumerate().filter(|(_, row)| row.len() != columns) {
        faults.push(
            format!("/model/weights/{i}"),
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

fn read_domain(slice: &[u8], faults: &mut Faults) -> Option<spec::Domain> {
    let body: DomainBody = read_object(slice, "/domain", faults)?;
    for (key, ends) in [("u", body.u), ("v", body.v)] {
        if let Some([low, high]) = ends
            && low > high
        {
            faults.push(
                format!("/domain/{key}"),
                format!("{} is greater than {}; write [min, max]", Shown(low), Shown(high)),
            );
        }
    }
    let interval = |ends: [f64; 2]| ends.map(unsigned_zero);
    Some(spec::Domain { u: body.u.map(interval), v: body.v.map(interval) })
}
