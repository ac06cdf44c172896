//! Streams: nodes of a job that arrive block by block and become an iteration in the end.
//!
//! The store decides. Estimates in memory are a cache of it, and any process on the same store may
//! get the next block: a block is stored only behind the very blocks that its estimate has seen,
//! and nothing is refused, answered again or finished before the store has been read.

mod blocks;
mod cache;
mod error;
mod estimates;
mod host;
mod lifecycle;
mod state_codec;
mod stream;

pub use cache::StreamCache;
pub use error::StreamError;
pub use host::StreamHost;
pub use state_codec::is_state;
pub use stream::{Block, FinishedStream, NewBlock, NewStream, PostedBlock, Stream, StreamState};
