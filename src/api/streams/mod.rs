//! Streams of nodes.

pub mod state;
pub mod stream;
