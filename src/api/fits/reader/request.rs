//! The top level of a fit request.

use super::{csv, nodes::RawNodes, spec};
use crate::api::{
    faults::Faults,
    fits::spec::{nodes::PostedNodesMembers, request::FitSpecMembers},
    json::{
        error::ReadError,
        members::of_request,
        request::{ReadWhole, Request},
    },
};
use flankfit_engine::estimation::{FitSpec, Nodes};

type MembersOf<'a, R> = <R as Request>::Members<'a>;

pub fn read_fit<E: ReadWhole>(text: &[u8]) -> Result<(Nodes, FitSpec, E), ReadError> {
    let mut faults = Faults::default();
    let (nodes, spec, extra): (PostedNodesMembers, FitSpecMembers, MembersOf<E>) = of_request(text, &mut faults)?;
    let nodes = RawNodes::required(nodes.nodes, &mut faults);
    finish::<_, E>(nodes, &spec, &extra, faults)
}

pub fn read_refit<E: ReadWhole>(text: &[u8]) -> Result<(FitSpec, E), ReadError> {
    let mut faults = Faults::default();
    let (spec, extra): (FitSpecMembers, MembersOf<E>) = of_request(text, &mut faults)?;
    finish::<_, E>(Some(()), &spec, &extra, faults).map(|((), spec, extra)| (spec, extra))
}

pub fn read_fit_with_csv<E: ReadWhole>(spec: &[u8], nodes: &[u8]) -> Result<(Nodes, FitSpec, E), ReadError> {
    let mut faults = Faults::default();
    let (spec, extra): (FitSpecMembers, MembersOf<E>) = of_request(spec, &mut faults)?;
    let nodes = match csv::read(nodes) {
        Err(ReadError::Invalid(found)) => {
            faults.append(found);
            None
        }
        read => Some(read?),
    };
    finish::<_, E>(nodes, &spec, &extra, faults)
}

fn finish<N, E: ReadWhole>(
    nodes: Option<N>,
    spec: &FitSpecMembers<'_>,
    extra: &MembersOf<'_, E>,
    mut faults: Faults,
) -> Result<(N, FitSpec, E), ReadError> {
    let spec = spec::read(spec, &mut faults);
    let extra = E::read(extra, &mut faults);
    match (nodes, spec, extra) {
        (Some(nodes), Some(spec), Some(extra)) => Ok(faults.into_result((nodes, spec, extra))?),
        _ => Err(faults.into()),
    }
}
