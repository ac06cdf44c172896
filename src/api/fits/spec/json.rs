//! A spec as JSON with every default filled in, for storing and for the digest.

use super::{
    include::named,
    request::{FitFields, FitSpecBody},
};
use crate::api::json::writer::text_of;
use flankfit_engine::estimation::spec::{ErrorModel, FitSpec, Variance};

/// The canonical JSON text: keys in the contract's order, defaults written out, no white space, −0
/// as 0.
pub fn to_json(spec: &FitSpec) -> String {
    text_of(&FitSpecBody::from(spec))
}

impl From<&FitSpec> for FitSpecBody {
    fn from(spec: &FitSpec) -> Self {
        let spec = spec.clone();
        FitSpecBody {
            model: spec.model,
            fit: FitFields {
                scaling: Some(spec.scaling),
                regularization: Some(spec.regularization),
                estimator: Some(spec.estimator),
                coefficient_norm_limit: spec.coefficient_norm_limit,
                noise_sigma: spec.noise_sigma,
                node_uncertainty: spec.node_uncertainty,
                errors: spec.errors.map(|errors| ErrorModel(Some(errors))),
                variance: (spec.variance != Variance::Constant).then_some(spec.variance),
                level: Some(spec.level),
                include: named(spec.include),
                filters: (!spec.filters.is_empty()).then_some(spec.filters),
            },
            domain: spec.domain,
            prior: spec.prior,
            constraints: (!spec.constraints.is_empty()).then_some(spec.constraints),
            predict: spec.predict,
            select: spec.select,
            folds: spec.folds,
            exclude: (!spec.exclude.is_empty()).then_some(spec.exclude),
        }
    }
}
