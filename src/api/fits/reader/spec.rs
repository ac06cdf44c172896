//! Everything about a fit but the nodes: wire parts to a checked [`FitSpec`], with the contract's
//! defaults and ranges.

use super::{fields, model::model};
use crate::api::{
    faults::Faults,
    fits::spec::{request::*, zeros::unsigned_zero},
    json::value::read_object,
};
use flankfit_engine::{
    estimation::{FitSpec, spec},
    words::Shown,
};

/// The spec, when none of its members has a fault.
pub fn read(members: &FitSpecMembers<'_>, faults: &mut Faults) -> Option<FitSpec> {
    let before = faults.count();
    let model = members.model.required_with(faults, model);
    // The rest is looked at in any case: all faults are reported at once.
    let domain = members.domain.text().and_then(|slice| read_domain(slice, faults));
    let prior = members.prior.text().and_then(|slice| super::prior::read(slice, faults));
    let constraints = members.constraints.text().and_then(|slice| super::constraints::read(slice, faults));
    let predict = members.predict.text().and_then(|slice| super::predict::read(slice, faults));
    let select = members.select.text().and_then(|slice| super::select::read(slice, faults));
    let folds = members.folds.text().and_then(|slice| super::folds::read(slice, faults));
    let exclude = members.exclude.text().and_then(|slice| super::exclude::read(slice, faults)).unwrap_or_default();
    // nothing is regularised beside a prior, nor beside constraints
    let regularization = match (&prior, constraints.as_deref()) {
        (None, None | Some([])) => spec::Regularization::default(),
        _ => spec::Regularization::None,
    };
    let constraints = constraints.unwrap_or_default();
    let fit = fields::of_model(&members.fit, model.unwrap_or(spec::Model::Linear), regularization, faults);
    let whole = |fit| FitSpec { domain, prior, constraints, predict, select, folds, exclude, ..fit };
    fit.filter(|_| faults.count() == before).map(whole)
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
