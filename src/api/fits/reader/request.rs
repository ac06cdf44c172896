//! The top level of a fit request.

use super::{nodes::RawNodes, spec};
use crate::api::{
    faults::Faults,
    fits::spec::{nodes::PostedNodesMembers, request::FitSpecMembers},
    json::{
        cursor::Cursor,
        error::ReadError,
        members::{Members, of_request},
        request::{ReadWhole, Request},
        writer::text_of,
    },
    measurand::axes::MeasurandBody,
    tables::{
        mapping,
        nodes::{self, TableNodes},
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

pub fn read_fit_with_table<E: ReadWhole>(
    spec: &[u8],
    nodes: &[u8],
    mapping: Option<&[u8]>,
) -> Result<(Nodes, FitSpec, E), ReadError> {
    let mut faults = Faults::default();
    let read = mapping::read(mapping)
        .and_then(|mapping| nodes::table(nodes, mapping.as_ref(), "/nodes"))
        .and_then(|table| nodes::only(&table, "/nodes"));
    let (nodes, measurand) = match read {
        Err(ReadError::Invalid(found)) => {
            faults.append(found);
            (None, None)
        }
        read => {
            let TableNodes { nodes, measurand, .. } = read?;
            (Some(nodes), Some(measurand))
        }
    };
    let said = measurand.as_ref().map_or(Vec::new(), said_by_table);
    let (spec, mut extra): (FitSpecMembers, MembersOf<E>) = of_request(spec, &mut faults)?;
    let mut names = Vec::new();
    extra.list(&mut names);
    for (name, text) in &said {
        if names.contains(&(*name, false)) {
            // text of the contract, which is JSON
            let _taken = extra.take(name, &mut Cursor::new(text.as_bytes()));
        }
    }
    finish::<_, E>(nodes, &spec, &extra, faults)
}

/// Returns the measurand of a table, as members of a request.
fn said_by_table(measurand: &MeasurandBody) -> Vec<(&'static str, String)> {
    let MeasurandBody { flank, tooth, axes } = measurand;
    let each = [
        ("flank", flank.as_ref().map(text_of)),
        ("tooth", tooth.as_ref().map(text_of)),
        ("axes", axes.as_ref().map(text_of)),
    ];
    each.into_iter().filter_map(|(name, text)| Some((name, text?))).collect()
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
