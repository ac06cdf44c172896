//! Entries of the audit.

use uuid::Uuid;

use crate::{
    jobs::{
        Cursor, Page, RepositoryError,
        audit::{Contents, Entry, Head},
    },
    store::sql::{
        columns::{Digest, Integer, Moment},
        error::{Outcome, damaged},
    },
};

/// The columns of [`EntryRow`].
macro_rules! entry_columns {
    () => {
        "number, id, at, actor, action, target, request_id, peer, contents, outcome, previous, sha256"
    };
}
pub(in crate::store) use entry_columns;

row! {
    pub struct EntryRow {
        number: Integer<u64>,
        id: Uuid,
        at: Moment,
        actor: String,
        action: String,
        target: String,
        request_id: Option<String>,
        peer: Option<String>,
        contents: Vec<u8>,
        outcome: String,
        previous: Digest,
        sha256: Digest,
    }
}

impl EntryRow {
    /// The entry; `None` where its contents do not read.
    pub fn entry(self) -> Option<Entry> {
        Some(Entry {
            number: self.number.0,
            id: self.id,
            at: self.at.0,
            actor: self.actor.into(),
            action: self.action.into(),
            target: self.target,
            request_id: self.request_id.map(Into::into),
            peer: self.peer.map(Into::into),
            contents: Contents::read(&self.contents)?,
            outcome: self.outcome.into(),
            previous: self.previous.0,
            sha256: self.sha256.0,
        })
    }
}

/// A page of so many entries. One row more than that tells whether there is a next page.
pub fn entries(rows: Vec<EntryRow>, limit: u32) -> Outcome<Page<Entry>> {
    let read = |row: EntryRow| row.entry().ok_or_else(|| RepositoryError::Failed(damaged("an entry", "of the audit")));
    let rows: Vec<Entry> = rows.into_iter().map(read).collect::<Result<_, _>>()?;
    Ok(Page::of(rows, limit, |entry| Cursor::after_number(entry.number)))
}

row! {
    /// The last entry of a chain.
    pub struct HeadRow {
        number: Integer<u64>,
        sha256: Digest,
    }
}

impl From<HeadRow> for Head {
    fn from(HeadRow { number, sha256 }: HeadRow) -> Self {
        Head { number: number.0, sha256: sha256.0 }
    }
}
