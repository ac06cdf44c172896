//! What a purge says of what it leaves: digests of the rows without what was taken away, and of the
//! entries without the names of those who made them. From then on these are what is compared.

use super::{
    contents::Contents,
    digests::{job_digest, purge_digest},
    entry::Entry,
    found::Found,
    layout::{Fields, Sha256Digest},
};
use crate::jobs::{job::Job, purge::Purge};

/// Entries without their names, one after the other. The digest of the whole entry stays, so that
/// the chain holds, and so that it can be held against the entry in the archive.
#[derive(Default)]
pub struct Nameless {
    fields: Fields,
    /// The number of the first that no purge has told of so far, and how many these are.
    pub first: Option<u64>,
    pub count: u64,
}

impl Nameless {
    /// Takes the next entry, if its name was taken away.
    pub fn entry(&mut self, entry: &Entry) {
        if entry.is_nameless() {
            let fields = std::mem::take(&mut self.fields);
            self.fields = fields.bytes(&entry.digest()).bytes(&entry.sha256);
            self.first = self.first.or(Some(entry.number));
            self.count += 1;
        }
    }

    /// The digest of those that came.
    pub fn digest(&mut self) -> Sha256Digest {
        (self.first, self.count) = (None, 0);
        std::mem::take(&mut self.fields).digest()
    }
}

/// The contents of the entry of a purge: of the job as it is then, of what is found of it when all
/// was taken away, and of the entries before.
pub fn purged(job: &Job, purge: &Purge, found: &Found, entries: &mut Nameless) -> Contents {
    Contents::of(vec![
        ("archive", purge.archive_sha256),
        ("entries", entries.digest()),
        ("found", found.digest()),
        ("job", job_digest(job)),
        ("purge", purge_digest(job.id, purge)),
        ("streams", found.streams_digest()),
    ])
}
