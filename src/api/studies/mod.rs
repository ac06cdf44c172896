//! The randomisation study of the paper.

pub mod reader;
pub mod request;
pub mod result;
