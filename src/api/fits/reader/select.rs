//! Which of several models is fitted: wire form to checked values.

use crate::api::{
    faults::Faults,
    fits::spec::{
        request::DegreeBody,
        select::{SelectBody, TermSearchName},
    },
    json::value::read_object,
};
use flankfit_engine::estimation::spec::{Candidates, Degree, Select, TermSearch};

/// Share of the absolute values in the penalty where none is told.
const DEFAULT_ALPHA: f64 = 0.5;

/// The selection, when nothing is wrong with it; whether it suits model and nodes is the engine's
/// to say.
pub fn read(slice: &[u8], faults: &mut Faults) -> Option<Select> {
    let body: SelectBody = read_object(slice, "/select", faults)?;
    if body.alpha.is_some() && body.terms != Some(TermSearchName::ElasticNet) {
        faults.push("/select/alpha", "only `elastic_net` takes it");
        return None;
    }
    let candidates = match (body.degrees, body.terms) {
        (Some(DegreeBody::Both(p)), None) => Candidates::Degrees(Degree::Both(p)),
        (Some(DegreeBody::Each([p, q])), None) => Candidates::Degrees(Degree::Each(p, q)),
        (None, Some(TermSearchName::Backward)) => Candidates::Terms(TermSearch::Backward),
        (None, Some(TermSearchName::ElasticNet)) => {
            Candidates::Terms(TermSearch::ElasticNet { alpha: body.alpha.unwrap_or(DEFAULT_ALPHA) })
        }
        (Some(_), Some(_)) => {
            faults.push("/select/terms", "give either `degrees` or `terms`, not both");
            return None;
        }
        (None, None) => {
            faults.push("/select", "give `degrees` or `terms`");
            return None;
        }
    };
    Some(Select { candidates, criterion: body.criterion.into(), hierarchical: body.hierarchical.unwrap_or(true) })
}
