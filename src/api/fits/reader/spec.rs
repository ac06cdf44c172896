//! Everything about a fit but the nodes: members of a request to a [`FitSpec`].

use super::fields;
use crate::api::{faults::Faults, fits::spec::request::FitSpecMembers, json::members::Member};
use flankfit_engine::{
    estimation::{
        FitSpec,
        spec::{Domain, Model, Regularization},
    },
    words::Shown,
};

/// The spec, when none of its members has a fault.
pub fn read(members: &FitSpecMembers<'_>, faults: &mut Faults) -> Option<FitSpec> {
    let before = faults.count();
    let model = members.model.required(faults);
    // The rest is read in any case: all errors are reported at once.
    let domain = read_domain(&members.domain, faults);
    let prior = members.prior.read(faults);
    let constraints = members.constraints.read(faults);
    let predict = members.predict.read(faults);
    let select = members.select.read(faults);
    let folds = members.folds.read(faults);
    let exclude = members.exclude.read(faults).unwrap_or_default();
    // nothing else is regularised with a prior, nor with constraints
    let regularization = match (&prior, constraints.as_deref()) {
        (None, None | Some([])) => Regularization::default(),
        _ => Regularization::None,
    };
    let constraints = constraints.unwrap_or_default();
    let fit = fields::of_model(&members.fit, model.unwrap_or(Model::Linear), regularization, faults);
    let whole = |fit| FitSpec { domain, prior, constraints, predict, select, folds, exclude, ..fit };
    fit.filter(|_| faults.count() == before).map(whole)
}

fn read_domain(member: &Member<'_, Domain>, faults: &mut Faults) -> Option<Domain> {
    let domain = member.read(faults)?;
    for (key, ends) in [("u", domain.u), ("v", domain.v)] {
        if let Some([low, high]) = ends
            && low > high
        {
            let detail = format!("{} is greater than {}; write [min, max]", Shown(low), Shown(high));
            faults.push(format!("{}/{key}", member.pointer()), detail);
        }
    }
    Some(domain)
}
