//! Maintenance operations as data.

use std::sync::Arc;

use jiff::{SignedDuration, Timestamp};
use uuid::Uuid;

use super::{operation::Operation, subject::Subject};
use crate::jobs::{
    ClaimedTask, EndedTask, KeyId, KnownKey, Lease, San,
    audit::{Sealing, WholeSeal},
};

/// Forgets kept answers from before a time, the oldest first, at most so many; answers how many.
pub struct ForgetAnswers {
    pub before: Timestamp,
    pub most: u32,
}

impl Operation for ForgetAnswers {
    type Reply = u64;
}

/// How often it is noted how far what is told of all jobs has come.
pub const NOTED_EVERY: SignedDuration = SignedDuration::from_hours(1);

/// Notes how far what is told of all jobs has come, and forgets what was told before a time, the
/// oldest first, at most so many; answers how many.
pub struct ForgetTold {
    pub now: Timestamp,
    pub before: Timestamp,
    pub most: u32,
}

impl Operation for ForgetTold {
    type Reply = u64;
}

/// Bytes written to test whether the database is writable: more than a small iteration needs, since
/// a few bytes may fit where an iteration does not.
pub static PROBE: [u8; 64 << 10] = [0; 64 << 10];

/// Writes a test row, to check that the database accepts writes.
pub struct Probe {
    pub now: Timestamp,
}

impl Operation for Probe {
    type Reply = ();
}

/// The key of an id.
pub struct FindKey {
    pub id: KeyId,
}

impl Operation for FindKey {
    type Reply = Option<KnownKey>;
}

/// The key of certificates with a name.
pub struct FindCertificate {
    pub san: San,
}

impl Operation for FindCertificate {
    type Reply = Option<KnownKey>;
}

/// Whether there is a key.
pub struct HasKeys;

impl Operation for HasKeys {
    type Reply = bool;
}

/// Writes down when keys were used last.
pub struct NoteUses {
    pub uses: Vec<(KeyId, Timestamp)>,
}

impl Operation for NoteUses {
    type Reply = ();
}

/// Seals the chains that grew; answers the seals, or none where another process is at it.
pub struct SealAudit(pub Sealing);

impl Operation for SealAudit {
    type Reply = Option<Vec<WholeSeal>>;
}

/// Takes the task that is next.
pub struct ClaimTask {
    pub lease: Uuid,
    pub now: Timestamp,
    pub lasting: SignedDuration,
}

impl Operation for ClaimTask {
    type Reply = Option<ClaimedTask>;
}

/// Prolongs leases, each with how far its task is; answers those that hold.
pub struct RenewTasks {
    pub leases: Vec<(Lease, f64)>,
    pub now: Timestamp,
    pub lasting: SignedDuration,
}

impl Operation for RenewTasks {
    type Reply = Vec<Lease>;
}

/// Writes down the end of a task; answers whether its lease held.
pub struct EndTask {
    pub ended: Arc<EndedTask>,
}

impl Operation for EndTask {
    type Reply = bool;

    fn bytes(&self) -> usize {
        self.ended.answer.body.len()
    }

    /// It is an event of the job.
    fn subject(&self) -> Subject {
        self.ended.job.map_or(Subject::Nothing, Subject::Job)
    }
}

/// Gives a task back to whoever takes it after a time.
pub struct GiveTaskBack {
    pub lease: Lease,
    pub until: Timestamp,
    pub counts: bool,
}

impl Operation for GiveTaskBack {
    type Reply = ();
}

/// Forgets tasks that ended before a time, at most so many; answers how many.
pub struct ForgetTasks {
    pub before: Timestamp,
    pub most: u32,
}

impl Operation for ForgetTasks {
    type Reply = u64;
}
