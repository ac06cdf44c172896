//! Streams of nodes.

mod problem;
pub mod stream;
