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
                "The gear of the job was changed while the file was read by it; nothing was stored. Send it again.",
            ),
            RepositoryError::ToothMeasured { tooth, teeth, iteration } => {
                let of = iteration.map_or("an open stream".to_owned(), |number| format!("iteration {number}"));
                let detail = format!(
                    "A gear of {} has no tooth `{}`, which {of} is of; a job of its own can have the other gear.",
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
                    "The resource is at \"{current}\" now: get it again, look at what changed, and repeat the request \
                     with its ETag."
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
            RepositoryError::TenantExists => Problem::new(ProblemCode::Conflict, "There is a tenant of this name."),
            RepositoryError::KeyTaken => Problem::new(
                ProblemCode::IdempotencyKeyInUse,
                "Another request with this idempotency key has just been stored; send it again to get its answer.",
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
            Problem::new(ProblemCode::StoreUnavailable, "The store does not answer; nothing was stored.")
                .caused_by(cause)
                .retry_after(2)
        }
        RepositoryError::Unfit(unfit) => {
            Problem::new(ProblemCode::StoreUnavailable, "The store is not to be used now; nothing was stored.")
                .caused_by(unfit)
                .retry_after(2)
        }
        RepositoryError::OutcomeUnknown(cause) => Problem::new(
            ProblemCode::OutcomeUnknown,
            "The store was lost before it answered: everything was stored, or nothing. Send the request again with \
             the same Idempotency-Key, which stores nothing twice; one that had no key: look whether it is there.",
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
                "The job was purged at {} ({}); what was removed is gone, and the job cannot be changed any more.",
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
        RepositoryError::KeyRevoked => "The key is revoked, which is for good; make a new one.".to_owned(),
        RepositoryError::KeyEnded { at } => {
            format!("The key ended at {}, which is for good; make a new one.", Moment(*at))
        }
        RepositoryError::KeyReplaced { by } => {
            format!("Key {by} has taken the place of this one; rotate or change that one, or make a new one.")
        }
        RepositoryError::NoSecret => {
            "The key is of a certificate and has no secret; certificates are renewed by who signs them.".to_owned()
        }
        RepositoryError::SanTaken => "Another key is of certificates with this name; revoke that one first.".to_owned(),
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
