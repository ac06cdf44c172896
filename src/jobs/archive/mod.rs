//! What there is of a job, as text that is the same from every store: to take it elsewhere, and to
//! compare. The format is in `docs/how-to/data-life.md`.
//!
//! Each job is a section: a line for each row, then a line with the digest of those before it. A
//! store reads and writes rows; it stores a section as a whole or not at all.

mod carry;
mod error;
mod file;
mod row;
mod section;
mod table;
mod whole;

pub use carry::{copy, digest, export, import, is_new, listed};
pub use error::ArchiveError;
pub use file::{ArchiveReader, ArchiveWriter, Listed};
pub use row::{Row, Value};
pub use section::{Digested, Key, Section};
pub use table::{Column, Kind, TABLES, Table};
pub use whole::{Archived, archive};

use tokio::sync::mpsc;
use uuid::Uuid;

use super::{
    audit::Chain,
    callers::Tenant,
    outcome::{RepositoryError, RepositoryFuture},
};

/// Rows that are on their way from one store, or file, to another.
pub const ON_THE_WAY: usize = 8;

/// What is told to a store that stores a section.
#[derive(Debug)]
pub enum Coming {
    Row(Row),
    /// That was the last; what is stored then must have this digest.
    All(Digested),
}

/// The jobs of all tenants, as rows.
pub trait Holdings: Send + Sync {
    /// Every job that there is or was, in the order of tenants and ids.
    fn keys(&self) -> RepositoryFuture<'_, Vec<Key>>;

    /// Sends the rows of a job in the order of [`TABLES`], as one state of the store; none of a job
    /// that there is not and never was.
    fn read(&self, key: Key, to: mpsc::Sender<Row>) -> RepositoryFuture<'_, ()>;

    /// Stores the rows of a job that there is not, if all of them come, what is stored then has the
    /// digest that was told, and its audit agrees with it.
    fn write(&self, key: Key, from: mpsc::Receiver<Coming>) -> RepositoryFuture<'_, ()>;

    /// Ends the writing; whether all is in the file of the database alone, where it is a file. A
    /// program that reads it may keep it from that.
    fn close(&self) -> RepositoryFuture<'_, bool>;
}

/// The keys of jobs and chains in their order, without the chains that are of no job.
pub fn keys_of(all: Vec<(Tenant, Uuid)>) -> Vec<Key> {
    let keys = all.into_iter().map(|(tenant, job)| Key { tenant, job });
    let mut keys: Vec<_> = keys.filter(|key| key.job != Chain::Tenant.id(&key.tenant)).collect();
    keys.sort();
    keys
}

/// Why a store gives up a section that it was about to store.
pub fn given_up(why: &str) -> RepositoryError {
    RepositoryError::Failed(why.to_owned())
}
