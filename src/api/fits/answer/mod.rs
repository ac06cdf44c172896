//! The answer to a fit: its schema, and its text written without the structs of the schema.

pub mod parts;
pub mod regularization;
pub mod result;
pub mod robust;
mod shared_text;
pub mod text;
