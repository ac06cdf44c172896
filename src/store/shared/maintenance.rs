//! What is done for no caller, as data.

use jiff::Timestamp;

use super::operation::Operation;
use crate::jobs::{KeyId, KnownKey, San};

/// Forgets kept answers from before a time, the oldest first, at most so many; answers how many.
pub struct ForgetAnswers {
    pub before: Timestamp,
    pub most: u32,
}

impl Operation for ForgetAnswers {
    type Reply = u64;
}

/// Writes what nobody reads, to find out whether anything can be written.
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
