//! The randomisation study of the paper.

pub mod request;
pub mod result;
