//! Reading and writing JSON: a strict cursor, what serde reads of it, every fault by its JSON Pointer,
//! and text that is written without a tree.

pub mod cursor;
pub mod decimal;
pub mod error;
pub mod every;
pub mod extra;
pub mod fields;
pub mod merge;
pub mod nearest;
pub mod nulls;
pub mod numbers;
pub mod part;
pub mod pointer;
pub mod present;
pub mod tags;
pub mod text;
pub mod union_schema;
pub mod unique;
pub mod wording;
pub mod writer;
