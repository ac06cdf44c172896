//! How a model is fitted: as a fit request says it, and as requests do that fit something else than
//! posted nodes.

use crate::api::{
    faults::Faults,
    fits::spec::{include::include, request::FitFieldsMembers},
    json::members::given,
};
use flankfit_engine::estimation::{
    FitSpec,
    spec::{DEFAULT_LEVEL, Model, Regularization},
};

/// Reads the fit of a request that has no model of its own: least squares, unless it is
/// regularised. Where nothing is fitted none of the fields may be there, for the reason in `unfit`.
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
    let spec = FitSpec {
        scaling: fields.scaling.read(faults).unwrap_or_default(),
        regularization: fields.regularization.read(faults).unwrap_or(regularization),
        estimator: fields.estimator.read(faults).unwrap_or_default(),
        coefficient_norm_limit: fields.coefficient_norm_limit.read(faults),
        noise_sigma: fields.noise_sigma.read(faults),
        node_uncertainty: fields.node_uncertainty.read(faults),
        errors: fields.errors.read(faults).and_then(|errors| errors.0),
        variance: fields.variance.read(faults).unwrap_or_default(),
        level: fields.level.read(faults).unwrap_or(DEFAULT_LEVEL),
        include: fields.include.read(faults).map(|names| include(&names)).unwrap_or_default(),
        filters: fields.filters.read(faults).unwrap_or_default(),
        ..FitSpec::new(model)
    };
    (faults.count() == before).then_some(spec)
}
