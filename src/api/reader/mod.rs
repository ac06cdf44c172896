//! Reads fit requests: bytes in, checked nodes and spec out, every fault by its JSON Pointer.
//!
//! Number arrays are most of a fit request, and a general JSON deserializer spends most of its time
//! on them. So the request is walked by hand: the arrays of `nodes` go straight into `Vec<f64>`
//! (correctly rounded, strict JSON grammar), everything else is small and left to serde on its
//! slice of the text.
//!
//! Two kinds of refusal: text that is not JSON ([`ReadError::Malformed`], 400), and JSON that asks
//! for the impossible ([`ReadError::Invalid`], 422), of which all faults are collected before
//! answering.

mod csv;
mod cursor;
mod decimal;
mod estimator;
mod every;
mod fields;
mod filters;
mod nearest;
mod nodes;
mod nulls;
mod numbers;
mod regularization;
mod request;
mod spec;
#[cfg(test)]
mod tests;
mod wording;

/// Nodes from a table with a header.
pub use self::csv::read as read_csv;
/// For the parts of other requests.
pub(in crate::api) use self::{
    fields::{Fields, read_numbers, read_rows},
    regularization::parameter,
    request::read_part,
    spec::{RawSpec, SPEC_KEYS, read_tag, unknown_type},
};
/// For messages about what is not in a body.
pub use self::{request::escape, wording::alternatives};

use serde::de::DeserializeOwned;

use super::problem::{Problem, ProblemCode};
use crate::api::faults::Faults;
use flankfit_engine::estimation::{FitSpec, Nodes};

/// Why a body was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReadError {
    /// Not JSON (or not CSV), with the place.
    #[error("{detail}")]
    Malformed { detail: String },
    /// JSON (or CSV) that says what cannot be done.
    #[error("{} fault(s)", .0.count())]
    Invalid(Faults),
}

impl<F: Into<Faults>> From<F> for ReadError {
    fn from(faults: F) -> Self {
        ReadError::Invalid(faults.into())
    }
}

impl From<ReadError> for Problem {
    fn from(error: ReadError) -> Self {
        match error {
            ReadError::Malformed { detail } => Problem::new(ProblemCode::MalformedBody, detail),
            ReadError::Invalid(faults) => Problem::invalid(faults),
        }
    }
}

/// Fields that a request has beside those of a fit, such as an iteration's `operator`.
///
/// Deserialised from an object that holds only [`Extra::KEYS`]; optional fields should be
/// `#[serde(default)]`. Unknown keys of the request are refused before.
pub trait Extra: DeserializeOwned {
    /// The keys at the top level of the request.
    const KEYS: &'static [&'static str];
}

/// No further fields.
#[derive(Clone, Copy, Debug, Default, serde::Deserialize)]
pub struct NoExtra {}

impl Extra for NoExtra {
    const KEYS: &'static [&'static str] = &[];
}

/// Reads a fit request: `nodes`, the spec and the fields of `E`.
pub fn read_fit<E: Extra>(text: &[u8]) -> Result<(Nodes, FitSpec, E), ReadError> {
    request::read_fit(text)
}

/// Reads a fit request without nodes.
pub fn read_refit<E: Extra>(text: &[u8]) -> Result<(FitSpec, E), ReadError> {
    request::read_refit(text)
}

/// Reads nodes and the fields of `E`, without a spec: a block of a stream.
pub fn read_nodes<E: Extra>(text: &[u8]) -> Result<(Nodes, E), ReadError> {
    request::read_nodes(text)
}

/// Reads a fit request whose nodes come as CSV: the form of `multipart/form-data`.
pub fn read_fit_with_csv<E: Extra>(spec: &[u8], nodes: &[u8]) -> Result<(Nodes, FitSpec, E), ReadError> {
    request::read_fit_with_csv(spec, nodes)
}

/// Reads any small JSON body, which is an object; faults carry pointers.
pub fn read_json<T: DeserializeOwned>(text: &[u8]) -> Result<T, ReadError> {
    request::read_json(text)
}
