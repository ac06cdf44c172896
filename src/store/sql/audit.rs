//! The entries of the audit, and the rows that they have digests of.

use futures_util::TryStreamExt as _;
use sqlx::FromRow;
use uuid::Uuid;

use super::{
    db::{Db, Record},
    error::Outcome,
    growing::NewEntry,
    row::{FoundBlock, FoundFit, FoundIteration, FoundJobPurge, FoundNodes, FoundRow, FoundStreamRow, job_columns},
};
use crate::jobs::{
    Choice, DecisionEvent, Job, Record as JobRecord, Tenant,
    audit::{Found, FoundStream, Head, Versioned},
};

/// Returns the last entry of a chain.
pub async fn head(db: &mut Db, chain: Uuid) -> Outcome<Option<Head>> {
    let sql = "SELECT number, sha256 FROM audit WHERE chain = $1 ORDER BY number DESC LIMIT 1";
    Ok(db.maybe(sql, args![chain]).await?)
}

/// Stores entries.
pub async fn store(db: &mut Db, new: &[NewEntry]) -> Result<(), sqlx::Error> {
    let mut rows = Vec::with_capacity(new.len());
    for NewEntry { tenant, chain, entry } in new {
        rows.push(vec![
            tenant.into(),
            chain.into(),
            entry.number.into(),
            entry.id.into(),
            entry.at.into(),
            (&entry.actor).into(),
            (&*entry.action).into(),
            (&entry.target).into(),
            entry.request_id.as_deref().into(),
            entry.peer.as_deref().into(),
            entry.contents.bytes().into(),
            (&*entry.outcome).into(),
            (&entry.previous).into(),
            (&entry.sha256).into(),
        ]);
    }
    let columns = "tenant, chain, number, id, at, actor, action, target, request_id, peer, contents, outcome,
                   previous, sha256";
    db.insert("audit", columns, &rows).await
}

/// A row that reads, or none.
pub struct Readable<T>(pub Option<T>);

impl<'r, R: sqlx::Row, T: FromRow<'r, R>> FromRow<'r, R> for Readable<T> {
    fn from_row(row: &'r R) -> Result<Self, sqlx::Error> {
        Ok(Readable(T::from_row(row).ok()))
    }
}

row! {
    /// A row of an iteration, as the audit finds it.
    struct Numbered<T> {
        @row: Readable<T>,
        number: u64,
    }
}

/// Returns the rows of a job of a tenant; none of another tenant's job.
pub async fn found(db: &mut Db, tenant: &Tenant, job: Uuid) -> Outcome<Found> {
    let sql = concat!("SELECT ", job_columns!(), " FROM jobs WHERE id = $1 AND tenant = $2");
    let row: Option<Job> = db.maybe(sql, args![job, tenant]).await?;
    let Some(row) = row else { return Ok(Found::default()) };
    let mut found = Found::of_job(Versioned::job(&row));
    all::<FoundIteration>(db, job, &mut found).await?;
    all::<FoundNodes>(db, job, &mut found).await?;
    all::<FoundFit>(db, job, &mut found).await?;
    all::<Choice>(db, job, &mut found).await?;
    all::<DecisionEvent>(db, job, &mut found).await?;
    all::<JobRecord>(db, job, &mut found).await?;
    own(db, job, &mut found).await?;
    Ok(found)
}

/// Adds its purge and the rows of its streams.
async fn own(db: &mut Db, job: Uuid, found: &mut Found) -> Outcome<()> {
    let sql = "SELECT j.purged_at, p.at, p.reason, p.archive_sha256
               FROM jobs j LEFT JOIN purges p ON p.job = j.id WHERE j.id = $1";
    let purge: Option<Readable<FoundJobPurge>> = db.maybe(sql, args![job]).await?;
    found.purge = purge.and_then(|row| row.0.map_or(Some([0; 32]), |found| found.digest(job)));
    let sql = "SELECT id, spec, forgetting_factor, flank, tooth, axes, false AS units_accepted, created_at,
                      iteration IS NULL AS open
               FROM streams WHERE job = $1";
    let streams: Vec<FoundStreamRow> = db.all(sql, args![job]).await?;
    found.streams.extend(streams.into_iter().map(<(Uuid, FoundStream)>::from));
    let sql = "SELECT b.stream, b.sequence, b.sha256, b.count, b.data
               FROM streams s JOIN stream_blocks b ON b.stream = s.id WHERE s.job = $1";
    let mut blocks = db.each::<FoundBlock>(sql, args![job])?;
    while let Some(row) = blocks.try_next().await? {
        let (block, digest) = row.into();
        found.blocks.insert(block, digest);
    }
    Ok(())
}

/// Adds the rows of a kind, in order. A row that does not read is none that an entry is about.
async fn all<T: FoundRow>(db: &mut Db, job: Uuid, found: &mut Found) -> Outcome<()>
where
    Numbered<T>: Record,
{
    let mut rows = db.each::<Numbered<T>>(T::SQL, args![job])?;
    while let Some(Numbered { row: Readable(row), number }) = rows.try_next().await? {
        found.add(number, T::KIND, row.map_or([0; 32], FoundRow::digest));
    }
    Ok(())
}
