//! A spec as JSON with every default filled in, for storing and for the digest.

use super::{
    constraint::ConstraintBody, exclude::NodeAtBody, filters::FilterBody, include::named, model_json::model,
    regularization_json::regularization, request::*, zeros::unsigned_zero,
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
                    position_kind: uncertainty.kind.map(PositionKindName::from),
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
            constraints: (!spec.constraints.is_empty())
                .then(|| spec.constraints.iter().map(ConstraintBody::from).collect()),
            predict: spec.predict.as_ref().map(PredictBody::from),
            select: spec.select.as_ref().map(SelectBody::from),
            folds: spec.folds.as_ref().map(FoldsBody::from),
            exclude: (!spec.exclude.is_empty()).then(|| spec.exclude.iter().copied().map(NodeAtBody::from).collect()),
        }
    }
}
