//! What requests other than fits say of the fit that they ask for: as in a fit request, beside
//! model and domain.

use super::spec;
use crate::api::{
    faults::Faults,
    fits::spec::{
        filters::FilterBody,
        request::{EstimatorBody, FitSpecMembers, IncludeName, NodeUncertaintyBody, RegularizationBody, ScalingName},
    },
    json::{
        members::{Members, given},
        request::request,
    },
};
use flankfit_engine::estimation::{
    FitSpec,
    spec::{Model, Regularization},
};

request! {
    /// How is fitted; each as in a fit request.
    #[derive(Default)]
    pub struct FitFields as FitFieldsMembers {
        optional scaling: ScalingName,
        /// Default `none`.
        optional regularization: RegularizationBody,
        optional estimator: EstimatorBody,
        /// r ≥ ‖A‖ of Ineq. 51, in the scaled columns, for the bounds of the bias; by default
        /// estimated.
        #[schema(exclusive_minimum = 0)]
        optional coefficient_norm_limit: f64,
        /// Standard deviation of a height of weight 1, in the unit of the heights; by default
        /// estimated from the residuals.
        #[schema(exclusive_minimum = 0)]
        optional noise_sigma: f64,
        optional node_uncertainty: NodeUncertaintyBody,
        /// Level of confidence intervals, above 0.5 and below 1; default 0.95.
        #[schema(exclusive_minimum = 0.5, exclusive_maximum = 1, example = 0.95)]
        optional level: f64,
        /// Parts of the answer that come only when asked for.
        optional include: Vec<IncludeName>,
        /// Applied to the heights before the fit, in this order.
        #[schema(max_items = 16)]
        optional filters: Vec<FilterBody>,
    }
}

/// Reads the fields; the spec's model is still to be set. Where nothing is fitted none may be
/// there, and `unfit` says why.
pub fn read(fields: FitFieldsMembers<'_>, unfit: Option<&str>, faults: &mut Faults) -> Option<FitSpec> {
    if let Some(why) = unfit {
        let there = given(&fields);
        there.iter().for_each(|name| faults.push(format!("/{name}"), why));
        return there.is_empty().then(|| FitSpec::new(Model::Linear));
    }
    // What is asked for by name is least squares: nothing is regularised unless the request says
    // so.
    let regularized = fields.regularization.is_given();
    let spec = spec::without_model(&members_of_spec(fields), Model::Linear, faults)?;
    let regularization = if regularized { spec.regularization } else { Regularization::None };
    Some(FitSpec { regularization, ..spec })
}

fn members_of_spec(fields: FitFieldsMembers<'_>) -> FitSpecMembers<'_> {
    let FitFieldsMembers {
        scaling,
        regularization,
        estimator,
        coefficient_norm_limit,
        noise_sigma,
        node_uncertainty,
        level,
        include,
        filters,
    } = fields;
    FitSpecMembers {
        scaling,
        regularization,
        estimator,
        coefficient_norm_limit,
        noise_sigma,
        node_uncertainty,
        level,
        include,
        filters,
        ..FitSpecMembers::at("")
    }
}
