//! The randomisation study of the paper.

mod faults;
pub mod reader;
pub mod request;
pub mod result;
