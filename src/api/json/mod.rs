//! Reading and writing JSON: a strict cursor, what serde reads of it, every fault by its JSON
//! Pointer, and text that is written without a tree.

pub mod check;
mod compiled;
pub mod cursor;
pub mod error;
pub mod gather;
pub mod left_out;
pub mod location;
pub mod members;
pub mod merge;
pub mod nearest;
mod null_fields;
pub mod numbers;
pub mod raw;
pub mod reader;
pub mod refusal;
pub mod request;
pub mod text;
pub mod value;
pub mod wording;
pub mod writer;
