//! Rows that are changed where they are: of a job, a key and a tenant. An entry has the digest of
//! the row as it left it, so only the last of them tells of what is found.

use super::{
    digests::{job_digest, key_digest, plant_digest},
    entry::{Action, Entry},
    layout::Sha256Digest,
};
use crate::jobs::{
    callers::{ApiKey, NewKey, Plant},
    job::Job,
};

/// Such a row as it is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Versioned {
    pub digest: Sha256Digest,
    /// The same as servers tell it that do not know all of the row, where that differs.
    pub shorter: Option<Sha256Digest>,
    /// One more with each change.
    pub version: u64,
}

impl Versioned {
    /// One that does not read is none that an entry tells of.
    pub const UNREADABLE: Self = Versioned { digest: [0; 32], shorter: None, version: 0 };

    pub fn job(job: &Job) -> Self {
        Versioned { digest: job_digest(job), shorter: None, version: job.version }
    }

    pub fn key(new: &NewKey) -> Self {
        // a server of an older commit, beside this one, does not say what has replaced the key
        let shorter = new.key.replaced_by.map(|_| {
            let key = ApiKey { replaced_by: None, ..new.key.clone() };
            key_digest(&NewKey { key, ..new.clone() })
        });
        Versioned { digest: key_digest(new), shorter, version: new.key.version }
    }

    pub fn plant(plant: &Plant) -> Self {
        Versioned { digest: plant_digest(plant), shorter: None, version: plant.version }
    }
}

/// With which actions such a row begins, at version 1.
const BEGINNINGS: [Action; 4] = [Action::CreateJob, Action::CreateKey, Action::RotateKey, Action::CreateTenant];

/// Such a row as the last entry tells of it that does.
#[derive(Clone, Copy)]
pub struct LastTold {
    digest: Sha256Digest,
    by: u64,
    /// None of a row that is older than its chain: it was changed nobody knows how often.
    version: Option<u64>,
    /// For a key: whether another one has replaced it.
    replaced: bool,
}

impl LastTold {
    /// What is known once another entry has told of the row.
    pub fn told(before: Option<&Self>, digest: Sha256Digest, entry: &Entry) -> Self {
        let begins = || BEGINNINGS.iter().any(|action| *entry.action == *action.name());
        let version = match before {
            // a key that would have ended earlier anyway was told of when it was replaced, as long
            // as it did not say by which
            Some(before) if before.digest == digest => before.version,
            Some(before) => before.version.map(|version| version + 1),
            None => begins().then_some(1),
        };
        // the key that comes was not told of before
        let replaces = *entry.action == *Action::RotateKey.name();
        let replaced = before.is_some_and(|before| before.replaced || replaces);
        LastTold { digest, by: entry.number, version, replaced }
    }

    /// The entry that tells of it.
    pub fn by(&self) -> u64 {
        self.by
    }

    /// The number at fault, where the row is not as it was told. If it was changed more often than
    /// entries tell, it is that behind the last entry.
    pub fn fault(&self, found: Option<&Versioned>, next: u64) -> Option<u64> {
        match found {
            Some(found) if found.digest == self.digest => None,
            Some(found) if self.replaced && found.shorter == Some(self.digest) => None,
            Some(found) if self.version.is_some_and(|version| version < found.version) => Some(next),
            _ => Some(self.by),
        }
    }
}

#[cfg(test)]
mod tests {
    use jiff::Timestamp;
    use uuid::Uuid;

    use super::*;
    use crate::jobs::{
        audit::{By, Chain, Contents, Head, Prepared},
        callers::{Caller, KeyId, Role, Tenant},
    };

    /// A server of an older commit that changes a replaced key leaves out what has replaced it.
    #[test]
    fn a_replaced_key_may_be_told_of_without_what_has_replaced_it() {
        let key = |version, replaced_by: Option<u64>, name: &str| NewKey {
            key: ApiKey {
                id: KeyId::of(1),
                tenant: Tenant::default(),
                name: name.into(),
                role: Some(Role::Reader),
                scopes: Role::Reader.scopes(),
                san: None,
                version,
                created_at: Timestamp::UNIX_EPOCH,
                expires_at: Some(Timestamp::UNIX_EPOCH),
                last_used_at: None,
                revoked_at: None,
                replaced_by: replaced_by.map(KeyId::of),
            },
            sha256: Some([7; 32]),
        };
        let mut head = Head::before(Chain::Tenant, &Tenant::default());
        let caller = Caller::anonymous();
        let mut told = |before: Option<&LastTold>, action, digest| {
            let by = By { caller: &caller, at: Timestamp::UNIX_EPOCH };
            let entry =
                head.append(by, Prepared { id: Uuid::nil(), contents: Contents::default() }, action, "/".into());
            LastTold::told(before, digest, &entry)
        };
        let (before, link) = (key(2, None, "older"), key(2, Some(2), "older"));
        let made = told(None, Action::CreateKey, key_digest(&key(1, None, "new")));
        let changed = told(Some(&made), Action::ChangeKey, key_digest(&before));
        let rotated = told(Some(&made), Action::RotateKey, key_digest(&link));
        let by_older = told(Some(&rotated), Action::ChangeKey, key_digest(&key(3, None, "changed")));
        let found = |new: &NewKey| Versioned::key(new);
        assert_eq!(rotated.fault(Some(&found(&link)), 9), None);
        assert_eq!(by_older.fault(Some(&found(&key(3, Some(2), "changed"))), 9), None);
        // but a key that was not replaced is not said to be, and one that was is not let go
        assert_eq!(changed.fault(Some(&found(&link)), 9), Some(2));
        assert_eq!(rotated.fault(Some(&found(&before)), 9), Some(3));
        assert_eq!(by_older.fault(Some(&found(&key(3, Some(2), "other"))), 9), Some(4));
    }
}
