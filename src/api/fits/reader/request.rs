//! The top level of a fit request.

use super::{
    csv,
    nodes::RawNodes,
    spec::{RawSpec, SPEC_KEYS},
};
use crate::api::{
    faults::Faults,
    json::{
        cursor::{Cursor, Syntax, Token},
        error::{ReadError, malformed},
        extra::Extra,
        nulls,
        part::read_part,
        place::escape,
        wording::no_such_field,
    },
};
use flankfit_engine::estimation::{FitSpec, Nodes};

/// Which of the two big parts a request has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wanted {
    NodesAndSpec,
    Nodes,
    Spec,
}

/// A request as it was walked over.
#[derive(Default)]
struct Walked<'a> {
    nodes: Option<RawNodes<'a>>,
    spec: RawSpec<'a>,
    extras: Vec<(&'static str, &'a [u8])>,
    faults: Faults,
}

pub fn read_fit<E: Extra>(text: &[u8]) -> Result<(Nodes, FitSpec, E), ReadError> {
    let mut walked = walk::<E>(text, Wanted::NodesAndSpec)?;
    let nodes = match walked.nodes.take() {
        Some(raw) => keep(raw.check(), &mut walked.faults),
        None => {
            walked.faults.push("/nodes", "missing");
            None
        }
    };
    finish(nodes, walked)
}

pub fn read_refit<E: Extra>(text: &[u8]) -> Result<(FitSpec, E), ReadError> {
    let walked = walk::<E>(text, Wanted::Spec)?;
    finish(Some(()), walked).map(|((), spec, extra)| (spec, extra))
}

pub fn read_nodes<E: Extra>(text: &[u8]) -> Result<(Nodes, E), ReadError> {
    let mut walked = walk::<E>(text, Wanted::Nodes)?;
    let nodes = match walked.nodes.take() {
        Some(raw) => keep(raw.check(), &mut walked.faults),
        None => {
            walked.faults.push("/nodes", "missing");
            None
        }
    };
    let extra = read_extras(&walked.extras, &mut walked.faults);
    match (nodes, extra) {
        (Some(nodes), Some(extra)) => Ok(walked.faults.into_result((nodes, extra))?),
        _ => Err(walked.faults.into()),
    }
}

pub fn read_fit_with_csv<E: Extra>(spec: &[u8], nodes: &[u8]) -> Result<(Nodes, FitSpec, E), ReadError> {
    let mut walked = walk::<E>(spec, Wanted::Spec)?;
    let nodes = match csv::read(nodes) {
        Err(ReadError::Invalid(faults)) => keep(Err(faults), &mut walked.faults),
        read => Some(read?),
    };
    finish(nodes, walked)
}

fn finish<N, E: Extra>(nodes: Option<N>, mut walked: Walked) -> Result<(N, FitSpec, E), ReadError> {
    let spec = walked.spec.check(&mut walked.faults);
    let extra = read_extras(&walked.extras, &mut walked.faults);
    match (nodes, spec, extra) {
        (Some(nodes), Some(spec), Some(extra)) => Ok(walked.faults.into_result((nodes, spec, extra))?),
        _ => Err(walked.faults.into()),
    }
}

fn walk<E: Extra>(text: &[u8], wanted: Wanted) -> Result<Walked<'_>, ReadError> {
    let mut walked = Walked::default();
    let mut cursor = Cursor::new(text);
    walk_text::<E>(&mut cursor, wanted, &mut walked).map_err(|syntax| malformed(text, &syntax))?;
    nulls::refuse(&cursor, &mut walked.faults);
    Ok(walked)
}

fn walk_text<'a, E: Extra>(cursor: &mut Cursor<'a>, wanted: Wanted, walked: &mut Walked<'a>) -> Result<(), Syntax> {
    match cursor.token()? {
        Token::Object => {}
        other => {
            walked.faults.push("", format!("expected an object, found {}", other.name()));
            cursor.skip_value()?;
            return cursor.end();
        }
    }
    cursor.object(|cursor, key| {
        let key = key.as_ref();
        let twice = if wanted != Wanted::Spec && key == "nodes" {
            walked.nodes.replace(RawNodes::read(cursor)?).is_some()
        } else if let Some(place) = SPEC_KEYS.iter().position(|known| *known == key).filter(|_| wanted != Wanted::Nodes)
        {
            walked.spec.slices[place].replace(cursor.skip_value()?).is_some()
        } else if let Some(known) = E::KEYS.iter().find(|known| **known == key) {
            let twice = walked.extras.iter().any(|(there, _)| there == known);
            let slice = cursor.skip_value()?;
            // one of them will do to look at
            walked.extras.extend((!twice).then_some((*known, slice)));
            twice
        } else {
            let nodes = (wanted != Wanted::Spec).then_some("nodes");
            let spec = SPEC_KEYS.iter().filter(|_| wanted != Wanted::Nodes);
            let known: Vec<&str> = nodes.into_iter().chain(spec.chain(E::KEYS).copied()).collect();
            walked.faults.push(format!("/{}", escape(key)), no_such_field(key, &known));
            cursor.skip_value()?;
            false
        };
        if twice {
            walked.faults.push(format!("/{key}"), "the field stands twice");
        }
        Ok(())
    })?;
    cursor.end()
}

/// The fields of `E`, from an object that holds only them.
fn read_extras<E: Extra>(extras: &[(&'static str, &[u8])], faults: &mut Faults) -> Option<E> {
    let mut text = vec![b'{'];
    for (i, (key, slice)) in extras.iter().enumerate() {
        if i > 0 {
            text.push(b',');
        }
        text.push(b'"');
        text.extend_from_slice(key.as_bytes());
        text.extend_from_slice(b"\":");
        text.extend_from_slice(slice);
    }
    text.push(b'}');
    read_part(&text, "", faults)
}

fn keep<T>(result: Result<T, Faults>, faults: &mut Faults) -> Option<T> {
    match result {
        Ok(value) => Some(value),
        Err(found) => {
            faults.append(found);
            None
        }
    }
}
