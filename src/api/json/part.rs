//! The small parts of a request, which serde reads from their slices of the text.

use std::io::{BufReader, Read};

use serde::de::DeserializeOwned;

use super::{
    cursor::{Cursor, Token},
    error::{ReadError, malformed},
    every, nulls,
    pointer::escape,
    wording::explain,
};
use crate::api::faults::{Fault, Faults};
use flankfit_engine::numerics::cancel;

/// Reads any small JSON body, which is an object; faults carry pointers.
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
