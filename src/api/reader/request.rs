//! The top level of a fit request, and the small parts of it that serde reads.

use std::io::{BufReader, Read};

use serde::de::DeserializeOwned;

use super::{
    Extra, ReadError, csv,
    cursor::{Cursor, Syntax, Token, place},
    every,
    nodes::RawNodes,
    nulls,
    spec::{RawSpec, SPEC_KEYS},
    wording::{explain, no_such_field},
};
use crate::api::faults::{Fault, Faults};
use flankfit_engine::{
    estimation::{FitSpec, Nodes},
    numerics::cancel,
};

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

pub fn read_json<T: DeserializeOwned>(text: &[u8]) -> Result<T, ReadError> {
    // The walk finds what is not JSON, with the hints that the contract asks for; what serde then
    // refuses is well-formed.
    let mut cursor = Cursor::new(text);
    cursor.skip_value().and_then(|_| cursor.end()).map_err(|syntax| malformed(text, &syntax))?;
    let mut faults = Faults::default();
    nulls::refuse(&cursor, &mut faults);
    match read_object(text, "", &mut faults) {
        Some(value) => Ok(faults.into_result(value)?),
        None => Err(ReadError::Invalid(faults)),
    }
}

pub fn malformed(text: &[u8], syntax: &Syntax) -> ReadError {
    let (line, column) = place(text, syntax.at);
    ReadError::Malformed { detail: format!("Line {line}, column {column}: {}.", syntax.what) }
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

/// Bytes that serde reads within some hundredths of a second.
const LONG: usize = 4 << 20;

/// Passes a checkpoint at every read.
struct Asking<'a>(&'a [u8]);

impl Read for Asking<'_> {
    fn read(&mut self, room: &mut [u8]) -> std::io::Result<usize> {
        cancel::checkpoint();
        self.0.read(room)
    }
}

/// [`read_part`] of what must be an object: serde would take an array for the fields in their order
/// too.
pub fn read_object<T: DeserializeOwned>(text: &[u8], pointer: &str, faults: &mut Faults) -> Option<T> {
    match Cursor::new(text).token() {
        Ok(Token::Object) => read_part(text, pointer, faults),
        Ok(other) => {
            faults.push(pointer, format!("expected an object, found {}", other.name()));
            None
        }
        // The text has been walked over before.
        Err(syntax) => {
            faults.push(pointer, syntax.what);
            None
        }
    }
}

/// Reads well-formed JSON with serde; faults go to their pointers below `pointer`.
pub fn read_part<T: DeserializeOwned>(text: &[u8], pointer: &str, faults: &mut Faults) -> Option<T> {
    match deserialize(text) {
        Ok(value) => Some(value),
        Err(first) => {
            let further = every::further::<T>(text, &first);
            for Fault { pointer: place, detail } in [first].into_iter().chain(further) {
                faults.push(format!("{pointer}{place}"), detail);
            }
            None
        }
    }
}

/// The fault that serde meets first, if it meets one.
pub fn first_fault<T: DeserializeOwned>(text: &[u8]) -> Option<Fault> {
    deserialize::<T>(text).err()
}

fn deserialize<T: DeserializeOwned>(text: &[u8]) -> Result<T, Fault> {
    let read = if text.len() <= LONG {
        serde_path_to_error::deserialize(&mut serde_json::Deserializer::from_slice(text))
    } else {
        // serde does not ask whether it is still wanted, but what it reads from can
        let mut deserializer = serde_json::Deserializer::from_reader(BufReader::new(Asking(text)));
        serde_path_to_error::deserialize(&mut deserializer)
    };
    read.map_err(|error| {
        let mut pointer = String::new();
        for segment in error.path() {
            use serde_path_to_error::Segment;
            match segment {
                Segment::Seq { index } => pointer.push_str(&format!("/{index}")),
                Segment::Map { key } => pointer.push_str(&format!("/{}", escape(key))),
                Segment::Enum { .. } | Segment::Unknown => {}
            }
        }
        let (field, detail) = explain(&error.into_inner().to_string());
        if let Some(field) = field {
            let end = format!("/{}", escape(&field));
            if !pointer.ends_with(&end) {
                pointer.push_str(&end);
            }
        }
        Fault { pointer, detail }
    })
}

/// A key as a part of a JSON Pointer (RFC 6901).
pub fn escape(key: &str) -> String {
    // Keys come from the caller; a long one would only be echoed.
    let short: String = key.chars().take(64).collect();
    short.replace('~', "~0").replace('/', "~1")
}
