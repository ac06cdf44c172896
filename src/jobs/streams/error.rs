//! Why a use case of streams did not do what it was asked.

use crate::jobs::outcome::RepositoryError;

#[derive(Debug, thiserror::Error)]
pub enum StreamError {
    #[error(transparent)]
    Repository(#[from] RepositoryError),
    /// Blocks before this one are missing.
    #[error("block {sequence} came, block {expected} is expected")]
    BlockTooEarly { sequence: u64, expected: u64 },
    /// A block of this number is stored, with other nodes.
    #[error("block {sequence} is stored with other nodes, block {expected} is expected")]
    BlockChanged { sequence: u64, expected: u64 },
    /// A stream without nodes cannot be finished.
    #[error("the stream has no nodes")]
    NoNodes,
    /// The stored stream cannot be read.
    #[error("a stored stream is damaged: {0}")]
    Damaged(String),
}
