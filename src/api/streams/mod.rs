//! Streams of nodes.

pub mod listed;
mod problem;
pub mod stream;
