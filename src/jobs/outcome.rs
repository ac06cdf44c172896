//! Outcome of a write or a read, and errors of the store.

use std::pin::Pin;

use jiff::{SignedDuration, Timestamp};
use uuid::Uuid;

/// Kind of a resource that was not found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resource {
    Job,
    Iteration,
    Fit,
    Stream,
    Record,
    Key,
    Tenant,
}

/// Reason why a store that responds is not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unfit {
    #[error("the database has no schema yet: run `flankfit migrate`")]
    NoSchema,
    #[error("the schema of the database is older than this version: run `flankfit migrate`")]
    OldSchema,
    #[error("the schema needs a version that knows migration {0}")]
    NewSchema(i64),
    /// It takes no writes.
    #[error("the server is a standby")]
    Standby,
    /// Processes on one database give times to what they store.
    #[error("the clock of the database is {:.1} s before ours", .0.as_secs_f64())]
    Clock(SignedDuration),
    #[error("a file of the database was removed or replaced while it was open")]
    Misplaced,
}

/// Why the store did not do what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum RepositoryError {
    #[error("not found: {0:?}")]
    NotFound(Resource),
    /// A job with iterations is not deleted.
    #[error("the job has {0} iteration(s)")]
    HasIterations(u64),
    /// Nor is a job with streams.
    #[error("the job has {0} stream(s)")]
    HasStreams(u64),
    /// The job's gear has no such tooth.
    #[error("the job's gear has {teeth} teeth, not tooth {tooth}")]
    NoSuchTooth { tooth: String, teeth: u32 },
    /// The job's gear would lose a tooth that was measured: by an iteration, or by an open stream.
    #[error("a gear of {teeth} teeth has no tooth {tooth}")]
    ToothMeasured { tooth: String, teeth: u32, iteration: Option<u32> },
    /// The job no longer has the gear that the request is based on.
    #[error("the job's gear was changed meanwhile")]
    GearChanged,
    /// A finished stream takes nothing more.
    #[error("the stream has become iteration {iteration}")]
    StreamFinished { iteration: u32 },
    /// A block came before its turn, or after another one took its number.
    #[error("the stream expects block {expected}")]
    UnexpectedBlock { expected: u64 },
    /// The resource has moved on since the caller saw it.
    #[error("the resource is at version {current}")]
    VersionMismatch { current: u64 },
    /// A fit was named that belongs elsewhere or nowhere.
    #[error("fit {0} is not of this iteration")]
    ForeignFit(Uuid),
    /// The data were purged, or their job takes nothing more since then.
    #[error("purged at {at}: {reason}")]
    Purged { at: Timestamp, reason: String },
    /// An answer is already kept under this idempotency key.
    #[error("the idempotency key is taken")]
    KeyTaken,
    /// A revoked key is not changed any more.
    #[error("the key is revoked")]
    KeyRevoked,
    /// Nor is one that has ended by itself.
    #[error("the key ended at {at}")]
    KeyEnded { at: Timestamp },
    /// Another key took its place.
    #[error("key {by} has replaced the key")]
    KeyReplaced { by: String },
    /// A key of a certificate has no secret that another could take the place of.
    #[error("the key has no secret")]
    NoSecret,
    /// Another key is of certificates with this name.
    #[error("a key has this name of certificates")]
    SanTaken,
    #[error("there is a tenant of this name")]
    TenantExists,
    /// Too many writes wait; nothing was stored.
    #[error("the store's queue is full")]
    Overloaded,
    /// The store cannot be used now; nothing was stored.
    #[error("the store cannot be used now: {0}")]
    Unavailable(String),
    /// The store responds, and is not to be used now; nothing was stored.
    #[error("the store cannot be used now: {0}")]
    Unfit(Unfit),
    /// The store was lost while it was about to say that all is stored: all of it was, or nothing.
    #[error("it is not known whether it was stored: {0}")]
    OutcomeUnknown(String),
    /// Anything else; nothing was stored.
    #[error("the store failed: {0}")]
    Failed(String),
}

/// Future result of the store's methods.
pub type RepositoryFuture<'a, T> = Pin<Box<dyn Future<Output = Result<T, RepositoryError>> + Send + 'a>>;

/// Number and version that the store has given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stored {
    /// The number an iteration was given (0 for what has no number).
    pub number: u32,
    /// The version of the job or iteration after the change.
    pub version: u64,
}

/// Versions that the caller has seen (`If-Match`).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Precondition {
    #[default]
    None,
    /// One of these versions.
    AnyOf(Vec<u64>),
}

impl Precondition {
    /// Refuses a version that the caller has not seen.
    pub fn check(&self, current: u64) -> Result<(), RepositoryError> {
        match self {
            Precondition::AnyOf(seen) if !seen.contains(&current) => Err(RepositoryError::VersionMismatch { current }),
            _ => Ok(()),
        }
    }
}
