//! What is done for no caller, as data.

use jiff::Timestamp;

use super::operation::Operation;

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
