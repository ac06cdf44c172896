//! Values of a request that serde reads from their slices of the text.

use serde::Deserialize;
use utoipa::ToSchema;

use super::{
    check::{read_by, schema_of},
    cursor::{Cursor, Token},
    error::{ReadError, malformed},
};
use crate::api::faults::Faults;

/// Reads any small JSON body, which is an object; errors carry pointers.
pub fn read_json<'de, T: Deserialize<'de> + ToSchema>(text: &'de [u8]) -> Result<T, ReadError> {
    read_json_at(text, "")
}

/// Reads a body; pointers of errors begin with `pointer`.
pub fn read_json_at<'de, T: Deserialize<'de> + ToSchema>(text: &'de [u8], pointer: &str) -> Result<T, ReadError> {
    // The walk finds what is not JSON, with the hints that the contract asks for; what serde then
    // refuses is well-formed.
    let mut cursor = Cursor::new(text);
    cursor.skip_value().and_then(|_| cursor.end()).map_err(|syntax| malformed(text, &syntax))?;
    let mut faults = Faults::default();
    match read_object(text, pointer, &mut faults) {
        Some(value) => Ok(faults.into_result(value)?),
        None => Err(ReadError::Invalid(faults)),
    }
}

/// [`read_value`] of what must be an object, such as a union of objects.
pub fn read_object<'de, T: Deserialize<'de> + ToSchema>(
    text: &'de [u8],
    pointer: &str,
    faults: &mut Faults,
) -> Option<T> {
    match Cursor::new(text).token() {
        Ok(Token::Object) => read_value(text, pointer, faults),
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

/// Reads well-formed JSON with serde; pointers of errors begin with `pointer`.
pub fn read_value<'de, T: Deserialize<'de> + ToSchema>(
    text: &'de [u8],
    pointer: &str,
    faults: &mut Faults,
) -> Option<T> {
    read_by(&schema_of::<T>(), Some(0), text, pointer, faults)
}
