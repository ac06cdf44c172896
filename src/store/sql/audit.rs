//! The entries of the audit: made with the changes, and read.

use std::slice;

use futures_util::TryStreamExt as _;
use sqlx::{FromRow, postgres::PgRow, sqlite::SqliteRow};

use super::prelude::*;
use crate::jobs::{
    audit::{By, Contents, Sha256Digest, Signed},
    rows::Table,
};

/// The columns of an [`Entry`].
macro_rules! entry_columns {
    () => {
        "a.id, a.tenant, a.job, a.at, a.actor, a.action, a.subject, a.request_id, a.peer, a.contents, a.salt, a.who"
    };
}
pub(super) use entry_columns;

/// The columns of a [`Seal`].
macro_rules! seal_columns {
    () => {
        "tenant, number, at, last_entry, last_sha256, previous, sha256, signature, public_key"
    };
}
pub(super) use seal_columns;

from_row! {
    Entry { id, tenant, job, at, actor, action, subject, request_id, peer, contents, salt, who }
    Link { number, sha256 }
}

row! {
    struct Place {
        number: Option<u64>,
        sha256: Option<[u8; 32]>,
    }
}

row! {
    struct SealRow {
        tenant: crate::jobs::Tenant,
        number: u64,
        at: Timestamp,
        last_entry: u64,
        last_sha256: [u8; 32],
        previous: [u8; 32],
        sha256: [u8; 32],
        signature: Option<Vec<u8>>,
        public_key: Option<Vec<u8>>,
    }
}

/// Returns the bytes of a column; bytes that are no part of a valid signature where there are not
/// as many. (Zeros would be: a key of zeros has a small order, and some signatures by it hold.)
fn exactly<const N: usize>(bytes: Option<Vec<u8>>) -> [u8; N] {
    bytes.and_then(|bytes| bytes.try_into().ok()).unwrap_or([0xff; N])
}

impl From<SealRow> for Seal {
    fn from(row: SealRow) -> Self {
        let is_signed = row.signature.is_some() || row.public_key.is_some();
        let signed = Signed { public_key: exactly(row.public_key), signature: exactly(row.signature) };
        Seal {
            tenant: row.tenant,
            number: row.number,
            at: row.at,
            last: Link { number: row.last_entry, sha256: row.last_sha256 },
            previous: row.previous,
            sha256: row.sha256,
            signed: is_signed.then_some(signed),
        }
    }
}

macro_rules! of_parts {
    ($($Row:ty),*) => {
        $(impl<'r> FromRow<'r, $Row> for Seal {
            fn from_row(row: &'r $Row) -> Result<Self, sqlx::Error> {
                SealRow::from_row(row).map(Seal::from)
            }
        }

        impl<'r> FromRow<'r, $Row> for ListedEntry {
            fn from_row(row: &'r $Row) -> Result<Self, sqlx::Error> {
                let Place { number, sha256 } = Place::from_row(row)?;
                let place = number.zip(sha256).map(|(number, sha256)| Link { number, sha256 });
                Ok(ListedEntry { entry: Entry::from_row(row)?, place })
            }
        })*
    };
}

of_parts!(SqliteRow, PgRow);

/// An entry whose change is being made.
#[derive(Debug)]
pub struct Draft {
    entry: Entry,
    rows: Vec<(String, Sha256Digest)>,
}

impl Draft {
    pub fn new(by: By<'_>, tenant: &Tenant, job: Option<Uuid>, action: Action, subject: String) -> Outcome<Self> {
        let failed = |error| RepositoryError::Failed(format!("the system has no random numbers: {error}"));
        let entry = Entry::new(by, tenant, job, action, subject).map_err(failed).map_err(StoreError::from)?;
        Ok(Draft { entry, rows: Vec::new() })
    }

    /// Notes a row that is inserted with these columns.
    pub fn note(&mut self, table: &'static str, columns: &str, values: &[Value<'_>]) {
        if let Some(table) = Table::named(table) {
            self.note_row(table, &table.pick(&table.places(columns), values));
        }
    }

    fn note_row(&mut self, table: &Table, values: &[Value<'_>]) {
        self.note_digest(table.row_name(values), table.digest(self.salt(), values));
    }

    /// Notes the rows of a table that meet a condition now.
    pub async fn note_stored(
        &mut self,
        db: &mut Db,
        table: &'static str,
        condition: &str,
        args: &[Value<'_>],
    ) -> Outcome<()> {
        let Some(table) = Table::named(table) else { return Ok(()) };
        // something was changed before
        let late = |error| StoreError::from(error).too_late();
        let mut rows = db.rows(table, condition, args)?;
        while let Some(row) = rows.try_next().await.map_err(late)? {
            self.note_row(table, &row.values);
        }
        Ok(())
    }

    /// Notes the last event of the job, which a trigger has written.
    pub async fn note_event(&mut self, db: &mut Db, job: Uuid) -> Outcome<()> {
        self.note_stored(db, "events", "job = $1 ORDER BY number DESC LIMIT 1", args![job]).await
    }

    pub fn note_digest(&mut self, name: String, digest: Sha256Digest) {
        self.rows.push((name, digest));
    }

    pub fn salt(&self) -> &[u8] {
        self.entry.salt.as_deref().unwrap_or_default()
    }

    pub fn end(self) -> Entry {
        Entry { contents: Contents::of(self.rows), ..self.entry }
    }
}

/// Returns the statements that insert rows, each noted in the entry at its place, or all in the
/// only one.
pub fn insertion<'a>(
    db: &Db,
    table: &'static str,
    columns: &str,
    rows: Vec<Vec<Value<'a>>>,
    entries: &mut [Draft],
) -> Vec<Ready<'a>> {
    let last = entries.len().saturating_sub(1);
    if let Some(table) = Table::named(table) {
        let places = table.places(columns);
        debug_assert!(entries.len() == 1 || entries.len() == rows.len());
        for (k, row) in rows.iter().enumerate() {
            entries[k.min(last)].note_row(table, &table.pick(&places, row));
        }
    }
    db.insertion(table, columns, rows)
}

/// Inserts a row that is noted in an entry.
pub async fn insert(
    db: &mut Db,
    table: &'static str,
    columns: &str,
    row: Vec<Value<'_>>,
    entry: &mut Draft,
) -> Result<(), sqlx::Error> {
    db.run_together(insertion(db, table, columns, vec![row], slice::from_mut(entry))).await
}

/// Returns the statements that store entries.
pub fn storing<'a>(db: &Db, entries: &'a [Entry]) -> Vec<Ready<'a>> {
    let rows = entries
        .iter()
        .map(|entry| {
            vec![
                entry.id.into(),
                (&entry.tenant).into(),
                entry.job.into(),
                entry.at.into(),
                entry.actor.as_ref().into(),
                (&*entry.action).into(),
                (&entry.subject).into(),
                entry.request_id.as_ref().into(),
                entry.peer.as_ref().into(),
                entry.contents.bytes().into(),
                entry.salt.as_ref().into(),
                (&entry.who).into(),
            ]
        })
        .collect();
    let columns = "id, tenant, job, at, actor, action, subject, request_id, peer, contents, salt, who";
    db.insertion("audit", columns, rows)
}

pub async fn audit(
    db: &mut Db,
    Caller { tenant, .. }: &Caller,
    job: &Option<Uuid>,
    PageRequest { limit, after }: &PageRequest,
) -> Outcome<Page<ListedEntry>> {
    let sql = concat!(
        "SELECT ",
        entry_columns!(),
        ", c.number, c.sha256 FROM audit a LEFT JOIN audit_chain c ON c.entry = a.id
         WHERE a.tenant = $1 AND a.id > $2 AND (CAST($3 AS boolean) OR a.job = $4) ORDER BY a.id LIMIT $5"
    );
    let after = after.map_or(Uuid::nil(), |Cursor(id)| id);
    let args = args![tenant, after, job.is_none(), *job, i64::from(*limit) + 1];
    let rows: Vec<ListedEntry> = db.all(sql, args).await?;
    if let (Some(job), true) = (job, rows.is_empty()) {
        // a job that was deleted has entries
        super::jobs::located(db, tenant, *job).await?;
    }
    Ok(Page::of(rows, *limit, |listed| Cursor(listed.entry.id)))
}

pub async fn seals(
    db: &mut Db,
    Caller { tenant, .. }: &Caller,
    PageRequest { limit, after }: &PageRequest,
) -> Outcome<Page<Seal>> {
    let sql = concat!(
        "SELECT ",
        seal_columns!(),
        " FROM audit_seals WHERE tenant = $1 AND number > $2 ORDER BY number LIMIT $3"
    );
    let after = after.map_or(0, |cursor| cursor.number());
    let rows: Vec<Seal> = db.all(sql, args![tenant, after, i64::from(*limit) + 1]).await?;
    Ok(Page::of(rows, *limit, |seal: &Seal| Cursor::after_number(seal.number)))
}
