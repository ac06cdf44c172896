//! Why a use case did not do what it was asked.

use super::{engine::EngineError, repository::RepositoryError};

#[derive(Debug, thiserror::Error)]
pub enum JobsError {
    #[error(transparent)]
    Repository(#[from] RepositoryError),
    #[error(transparent)]
    Engine(#[from] EngineError),
}
