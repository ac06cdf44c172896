//! How is fitted, beside model and domain: as a fit request says it, and as requests do that make
//! a fit of something else than posted nodes.

use super::{estimator::read_estimator, regularization::read_regularization};
use crate::api::{
    faults::Faults,
    fits::spec::{include::include, request::*},
    json::{
        members::{Member, given},
        value::read_object,
    },
};
use flankfit_engine::{
    estimation::{
        FitSpec,
        spec::{self, Model, Regularization},
    },
    words::Shown,
};

/// What a request asks for that names its fit otherwise than by a model: least squares, unless it
/// says how to regularise. Where nothing is fitted none of the fields may be there, and `unfit`
/// says why.
pub fn read(fields: &FitFieldsMembers<'_>, unfit: Option<&str>, faults: &mut Faults) -> Option<FitSpec> {
    let Some(why) = unfit else { return of_model(fields, Model::Linear, Regularization::None, faults) };
    let there = given(fields);
    there.iter().for_each(|name| faults.push(format!("/{name}"), why));
    there.is_empty().then(|| FitSpec::new(Model::Linear))
}

/// The spec of `model`, when none of the fields has a fault; `regularization` where they name none.
pub fn of_model(
    fields: &FitFieldsMembers<'_>,
    model: Model,
    regularization: Regularization,
    faults: &mut Faults,
) -> Option<FitSpec> {
    let before = faults.count();
    let scaling = fields.scaling.read(faults).map(|name| match name {
        ScalingName::UnitLength => spec::Scaling::UnitLength,
        ScalingName::None => spec::Scaling::None,
        ScalingName::Standardized => spec::Scaling::Standardized,
    });
    let asked = fields.regularization.text().and_then(|slice| read_regularization(slice, faults));
    let estimator = fields.estimator.text().and_then(|slice| read_estimator(slice, faults));
    let coefficient_norm_limit = positive(&fields.coefficient_norm_limit, faults);
    let noise_sigma = positive(&fields.noise_sigma, faults);
    let node_uncertainty = fields.node_uncertainty.text().and_then(|slice| read_uncertainty(slice, faults));
    let errors = fields.errors.text().and_then(|slice| super::errors::read(slice, faults));
    let variance = fields.variance.text().and_then(|slice| super::errors::variance(slice, faults));
    let level = fields.level.read(faults);
    let include = fields.include.read(faults).map(|names| include(&names));
    let filters = fields.filters.text().and_then(|slice| super::filters::read(slice, faults));
    (faults.count() == before).then(|| FitSpec {
        scaling: scaling.unwrap_or_default(),
        regularization: asked.unwrap_or(regularization),
        estimator: estimator.unwrap_or_default(),
        coefficient_norm_limit,
        noise_sigma,
        node_uncertainty,
        errors,
        variance: variance.unwrap_or_default(),
        level: level.unwrap_or(spec::DEFAULT_LEVEL),
        include: include.unwrap_or_default(),
        filters: filters.unwrap_or_default(),
        ..FitSpec::new(model)
    })
}

fn positive(member: &Member<'_, f64>, faults: &mut Faults) -> Option<f64> {
    let value = member.read(faults)?;
    if value <= 0.0 {
        faults.push(member.pointer(), format!("{} is not greater than 0", Shown(value)));
    }
    Some(value)
}

fn read_uncertainty(slice: &[u8], faults: &mut Faults) -> Option<spec::NodeUncertainty> {
    let body: NodeUncertaintyBody = read_object(slice, "/node_uncertainty", faults)?;
    for (key, value) in [("position", body.position), ("height", body.height)] {
        if value < 0.0 {
            faults.push(format!("/node_uncertainty/{key}"), format!("{} is negative", Shown(value)));
        }
    }
    Some(spec::NodeUncertainty {
        position: body.position,
        height: body.height,
        kind: body.position_kind.map(spec::PositionKind::from),
    })
}
