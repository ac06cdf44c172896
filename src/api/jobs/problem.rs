//! Refusals of the store as problems.

use crate::{
    api::{
        faults::Faults,
        json::text::Moment,
        problem::{Problem, ProblemCode},
    },
    jobs::{RepositoryError, Resource},
};
use flankfit_engine::words::counted;

impl From<RepositoryError> for Problem {
    fn from(error: RepositoryError) -> Self {
        match error {
            RepositoryError::NotFound(what) => Problem::new(ProblemCode::NotFound, missing(what)),
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
            RepositoryError::NoSuchTooth { tooth, teeth } => {
                Problem::new(ProblemCode::Conflict, format!("Tooth {}.", no_such_tooth(&tooth, teeth)))
            }
            RepositoryError::GearChanged => Problem::new(
                ProblemCode::Conflict,
                "The gear of the job was changed while the file was read; nothing was stored. Send it again.",
            ),
            RepositoryError::ToothMeasured { tooth, teeth, iteration } => {
                let of = iteration.map_or("an open stream".to_owned(), |number| format!("iteration {number}"));
                let detail = format!(
                    "A gear of {} has no tooth `{}`, which {of} belongs to; create another job for the other gear.",
                    counted(teeth as usize, "tooth", "teeth"),
                    shown(&tooth)
                );
                Problem::new(ProblemCode::Conflict, detail)
            }
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
                    "The resource has changed; its version is {current} now. Get it again, review the changes, and \
                     repeat the request with its new ETag."
                ),
            ),
            RepositoryError::ForeignFit(id) => {
                Problem::invalid(Faults::one("/fit_id", format!("the iteration has no fit {id}")))
            }
            error @ RepositoryError::Purged { .. } => of_purge(error),
            error @ (RepositoryError::KeyRevoked
            | RepositoryError::KeyEnded { .. }
            | RepositoryError::KeyReplaced { .. }
            | RepositoryError::NoSecret
            | RepositoryError::SanTaken) => Problem::new(ProblemCode::Conflict, of_key(&error)),
            RepositoryError::TenantExists => {
                Problem::new(ProblemCode::Conflict, "A tenant of this name exists already.")
            }
            RepositoryError::KeyTaken => Problem::new(
                ProblemCode::IdempotencyKeyInUse,
                "Another request with this idempotency key has just been stored; send it again to get its response.",
            )
            .retry_after(1),
            error @ (RepositoryError::Overloaded
            | RepositoryError::Unavailable(_)
            | RepositoryError::Unfit(_)
            | RepositoryError::OutcomeUnknown(_)) => of_store(error),
            RepositoryError::Failed(cause) => Problem::internal(cause),
        }
    }
}

/// Returns the problem if the store or its disk accepts no writes.
fn of_store(error: RepositoryError) -> Problem {
    match error {
        RepositoryError::Overloaded => Problem::new(
            ProblemCode::Overloaded,
            "Too many writes are waiting; nothing was stored. Try again in a moment.",
        )
        .retry_after(1),
        RepositoryError::Unavailable(cause) => {
            Problem::new(ProblemCode::StoreUnavailable, "The store does not respond; nothing was stored.")
                .caused_by(cause)
                .retry_after(2)
        }
        RepositoryError::Unfit(unfit) => {
            Problem::new(ProblemCode::StoreUnavailable, "The store cannot be used now; nothing was stored.")
                .caused_by(unfit)
                .retry_after(2)
        }
        RepositoryError::OutcomeUnknown(cause) => Problem::new(
            ProblemCode::OutcomeUnknown,
            "The connection to the store was lost before it responded: everything was stored, or nothing. Send the \
             request again with the same Idempotency-Key, which stores nothing twice. Without a key, check whether \
             it was stored.",
        )
        .caused_by(cause)
        .retry_after(2),
        other => Problem::internal(other),
    }
}

/// Returns the problem about a purge, or about purged data.
fn of_purge(error: RepositoryError) -> Problem {
    match error {
        RepositoryError::Purged { at, reason } => Problem::new(
            ProblemCode::Purged,
            format!(
                "The job was purged at {} ({}); the removed data are lost, and the job cannot be changed any more.",
                Moment(at),
                reason.trim_end_matches('.')
            ),
        ),
        other => Problem::internal(other),
    }
}

/// Returns the message for a key that cannot be changed or made.
fn of_key(error: &RepositoryError) -> String {
    match error {
        RepositoryError::KeyRevoked => "The key is revoked for good; create a new one.".to_owned(),
        RepositoryError::KeyEnded { at } => {
            format!("The key expired at {} for good; create a new one.", Moment(*at))
        }
        RepositoryError::KeyReplaced { by } => {
            format!("Key {by} has replaced this one; rotate or change that key, or create a new one.")
        }
        RepositoryError::NoSecret => {
            "The key belongs to a certificate and has no secret; the certificate authority renews certificates."
                .to_owned()
        }
        RepositoryError::SanTaken => "Another certificate key has this name; revoke it first.".to_owned(),
        other => other.to_string(),
    }
}

/// Returns the message for a resource that does not exist.
fn missing(what: Resource) -> &'static str {
    match what {
        Resource::Job => "There is no such job.",
        Resource::Iteration => "The job has no such iteration.",
        Resource::Fit => "The iteration has no such fit.",
        Resource::Record => "The iteration has no such record.",
        Resource::Stream => "There is no such stream.",
        Resource::Key => "There is no such key.",
        Resource::Tenant => "There is no such tenant.",
    }
}

/// Returns the problem if the store refuses an iteration or a stream; its tooth is at the pointer
/// `at`.
pub fn of_measured(error: RepositoryError, at: &str) -> Problem {
    match error {
        RepositoryError::NoSuchTooth { tooth, teeth } => {
            Problem::invalid(Faults::one(at, no_such_tooth(&tooth, teeth)))
        }
        other => other.into(),
    }
}

fn no_such_tooth(tooth: &str, teeth: u32) -> String {
    format!("`{}` is not within 1 and {teeth}, the number of teeth of the job's gear", shown(tooth))
}

/// As much of a name as a message repeats.
fn shown(name: &str) -> String {
    name.chars().take(20).collect()
}
