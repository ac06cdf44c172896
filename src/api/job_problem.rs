//! What the store refuses, as problems.

use super::problem::{Problem, ProblemCode};
use crate::{
    estimation::{Faults, words::counted},
    jobs::{RepositoryError, What},
};

impl From<RepositoryError> for Problem {
    fn from(error: RepositoryError) -> Self {
        match error {
            RepositoryError::NotFound(what) => Problem::new(
                ProblemCode::NotFound,
                match what {
                    What::Job => "There is no such job.",
                    What::Iteration => "The job has no such iteration.",
                    What::Fit => "The iteration has no such fit.",
                    What::Record => "The iteration has no such record.",
                    What::Stream => "There is no such stream.",
                },
            ),
            RepositoryError::HasIterations(count) => Problem::new(
                ProblemCode::Conflict,
                format!(
                    "The job has {}; only a job without iterations can be deleted.",
                    counted(count as usize, "iteration", "iterations")
                ),
            ),
            RepositoryError::HasStreams(count) => Problem::new(
                ProblemCode::Conflict,
                format!("The job has {}, which must be deleted first.", counted(count as usize, "stream", "streams")),
            ),
            RepositoryError::StreamFinished { iteration } => Problem::new(
                ProblemCode::Conflict,
                format!("The stream is finished: it has become iteration {iteration} of its job."),
            ),
            RepositoryError::UnexpectedBlock { expected } => {
                Problem::new(ProblemCode::Conflict, format!("The stream expects block {expected} next."))
            }
            RepositoryError::VersionMismatch { current } => Problem::new(
                ProblemCode::PreconditionFailed,
                format!(
                    "The resource is at \"{current}\" now: get it again, look at what changed, and repeat the request with its ETag."
                ),
            ),
            RepositoryError::ForeignFit(id) => {
                Problem::invalid(Faults::one("/fit_id", format!("the iteration has no fit {id}")))
            }
            RepositoryError::KeyTaken => Problem::new(
                ProblemCode::IdempotencyKeyInUse,
                "Another request with this idempotency key has just been stored; send it again to get its answer.",
            )
            .retry_after(1),
            RepositoryError::Overloaded => Problem::new(
                ProblemCode::Overloaded,
                "Too many writes are waiting; nothing was stored. Try again in a moment.",
            )
            .retry_after(1),
            RepositoryError::Unavailable(cause) => {
                Problem::new(ProblemCode::StoreUnavailable, "The store does not answer; nothing was stored.")
                    .caused_by(cause)
                    .retry_after(2)
            }
            RepositoryError::Failed(cause) => Problem::internal(cause),
        }
    }
}
