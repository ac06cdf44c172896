//! What requests other than fits say of the fit that they ask for: as in a fit request, beside
//! model and domain.

use serde::Serialize;
use utoipa::ToSchema;

use super::spec::{RawSpec, SPEC_KEYS};
use crate::api::{
    faults::Faults,
    fits::spec::{
        filters::FilterBody,
        request::{EstimatorBody, IncludeName, NodeUncertaintyBody, RegularizationBody, ScalingName},
    },
    json::fields::Fields,
};
use flankfit_engine::estimation::{
    FitSpec,
    spec::{Model, Regularization},
};

/// The fields.
pub const FIT_KEYS: [&str; 8] = [
    "scaling",
    "regularization",
    "estimator",
    "coefficient_norm_limit",
    "noise_sigma",
    "node_uncertainty",
    "include",
    "filters",
];

// Declared for the document; `read` reads them.
/// How is fitted; each as in a fit request.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct FitFields {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scaling: Option<ScalingName>,
    /// Default `none`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub regularization: Option<RegularizationBody>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimator: Option<EstimatorBody>,
    /// r ≥ ‖A‖ of Ineq. 51, in the scaled columns, for the bounds of the bias; by default
    /// estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0)]
    pub coefficient_norm_limit: Option<f64>,
    /// Standard deviation of a height of weight 1, in the unit of the heights; by default estimated
    /// from the residuals.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0)]
    pub noise_sigma: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node_uncertainty: Option<NodeUncertaintyBody>,
    /// Parts of the answer that come only when asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub include: Option<Vec<IncludeName>>,
    /// Applied to the heights before the fit, in this order.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(max_items = 16)]
    pub filters: Option<Vec<FilterBody>>,
}

/// Reads the fields; the spec's model is still to be set. Where nothing is fitted none may be
/// there, and `unfit` says why.
pub fn read(fields: &Fields, unfit: Option<&str>, faults: &mut Faults) -> Option<FitSpec> {
    if let Some(why) = unfit {
        let before = faults.count();
        for key in FIT_KEYS.iter().filter(|key| fields.get(key).is_some()) {
            faults.push(format!("/{key}"), why);
        }
        return (faults.count() == before).then(|| FitSpec::new(Model::Linear));
    }
    let mut raw = RawSpec::default();
    for (slice, key) in raw.slices.iter_mut().zip(SPEC_KEYS) {
        if FIT_KEYS.contains(&key) {
            *slice = fields.get(key);
        }
    }
    let spec = raw.beside(Model::Linear, faults)?;
    // What is asked for by name is least squares: nothing is regularised unless the request says
    // so.
    let regularization =
        if fields.get("regularization").is_some() { spec.regularization } else { Regularization::None };
    Some(FitSpec { regularization, ..spec })
}
