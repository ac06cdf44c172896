//! Reads fit requests: bytes in, checked nodes and spec out, every fault by its JSON Pointer.
//!
//! Number arrays are most of a fit request, and a general JSON deserializer spends most of its time
//! on them. So the arrays of `nodes` go straight into `Vec<f64>` while the cursor passes (correctly
//! rounded, strict JSON grammar); everything else is small and left to serde on its slice of the
//! text.
//!
//! Two kinds of refusal: text that is not JSON ([`ReadError::Malformed`], 400), and JSON that is
//! invalid ([`ReadError::Invalid`], 422), of which all errors are collected.

pub mod fields;
pub mod nodes;
mod request;
pub mod spec;
#[cfg(test)]
mod tests;

use crate::api::json::{error::ReadError, request::ReadWhole};
use flankfit_engine::estimation::{FitSpec, Nodes};

/// Reads a fit request: `nodes`, the spec and the fields of `E`.
pub fn read_fit<E: ReadWhole>(text: &[u8]) -> Result<(Nodes, FitSpec, E), ReadError> {
    request::read_fit(text)
}

/// Reads a fit request without nodes.
pub fn read_refit<E: ReadWhole>(text: &[u8]) -> Result<(FitSpec, E), ReadError> {
    request::read_refit(text)
}

/// Reads a fit request whose nodes come as a table: the form of `multipart/form-data`. Axes, flank
/// and tooth of the table are taken where `E` has them and the spec does not give them.
pub fn read_fit_with_table<E: ReadWhole>(
    spec: &[u8],
    nodes: &[u8],
    mapping: Option<&[u8]>,
) -> Result<(Nodes, FitSpec, E), ReadError> {
    request::read_fit_with_table(spec, nodes, mapping)
}

/// Reads a stored spec (or any spec of a request).
pub fn read_stored(spec: &str) -> Result<FitSpec, ReadError> {
    request::read_refit(spec.as_bytes()).map(|(spec, ())| spec)
}
