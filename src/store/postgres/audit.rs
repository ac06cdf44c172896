//! The entries of the audit, and the rows that they have digests of.

use futures_util::TryStreamExt as _;
use sqlx::{FromRow, PgConnection, Row as _, postgres::PgRow};
use uuid::Uuid;

use super::{locate::signed, time::stamp};
use crate::{
    jobs::{
        Tenant,
        audit::{Entry, Found, Sha256Digest, Versioned},
    },
    store::shared::{
        ChoiceRow, DecisionRow, FoundBlock, FoundFitTold, FoundIteration, FoundJobPurge, FoundNodes, FoundRow,
        FoundStreamRow, HeadRow, JobRow, NewEntry, Outcome, RecordRow, figure_columns, job_columns,
    },
};

/// The last entries of chains.
pub async fn heads(db: &mut PgConnection, chains: &[Uuid]) -> Result<Vec<(Uuid, HeadRow)>, sqlx::Error> {
    row! {
        struct Row {
            @head: HeadRow,
            chain: Uuid,
        }
    }
    let rows: Vec<Row> = sqlx::query_as(
        "SELECT c.chain, a.number, a.sha256 FROM unnest($1::uuid[]) AS c (chain) CROSS JOIN LATERAL
             (SELECT number, sha256 FROM audit WHERE chain = c.chain ORDER BY number DESC LIMIT 1) AS a",
    )
    .bind(chains)
    .fetch_all(db)
    .await?;
    Ok(rows.into_iter().map(|row| (row.chain, row.head)).collect())
}

/// Whether a chain has this entry.
pub async fn is_there(db: &mut PgConnection, chain: Uuid, number: u64, id: Uuid) -> Result<bool, sqlx::Error> {
    let found: Option<Uuid> = sqlx::query_scalar("SELECT id FROM audit WHERE chain = $1 AND number = $2")
        .bind(chain)
        .bind(signed(number))
        .fetch_optional(db)
        .await?;
    Ok(found == Some(id))
}

/// Stores entries.
pub async fn store(db: &mut PgConnection, new: &[NewEntry]) -> Result<(), sqlx::Error> {
    let text = |of: fn(&Entry) -> &str| new.iter().map(|new| of(&new.entry)).collect::<Vec<_>>();
    let maybe = |of: fn(&Entry) -> Option<&str>| new.iter().map(|new| of(&new.entry)).collect::<Vec<_>>();
    let digest = |of: fn(&Entry) -> &Sha256Digest| new.iter().map(|new| of(&new.entry).as_slice()).collect::<Vec<_>>();
    sqlx::query(
        "INSERT INTO audit (tenant, chain, number, id, at, actor, action, target, request_id, peer, contents, outcome,
                            previous, sha256)
         SELECT * FROM unnest($1::text[], $2::uuid[], $3::bigint[], $4::uuid[], $5::timestamptz[], $6::text[],
                $7::text[], $8::text[], $9::text[], $10::text[], $11::bytea[], $12::text[], $13::bytea[], $14::bytea[])",
    )
    .bind(new.iter().map(|new| new.tenant.as_str()).collect::<Vec<_>>())
    .bind(new.iter().map(|new| new.chain).collect::<Vec<_>>())
    .bind(new.iter().map(|new| signed(new.entry.number)).collect::<Vec<_>>())
    .bind(new.iter().map(|new| new.entry.id).collect::<Vec<_>>())
    .bind(new.iter().map(|new| stamp(new.entry.at)).collect::<Vec<_>>())
    .bind(text(|entry| &entry.actor))
    .bind(text(|entry| &entry.action))
    .bind(text(|entry| &entry.target))
    .bind(maybe(|entry| entry.request_id.as_deref()))
    .bind(maybe(|entry| entry.peer.as_deref()))
    .bind(new.iter().map(|new| new.entry.contents.bytes()).collect::<Vec<_>>())
    .bind(text(|entry| &entry.outcome))
    .bind(digest(|entry| &entry.previous))
    .bind(digest(|entry| &entry.sha256))
    .execute(db)
    .await?;
    Ok(())
}

/// The rows of a job of a tenant; none of another's, which for this one does not exist.
pub async fn found(db: &mut PgConnection, tenant: &Tenant, job: Uuid) -> Outcome<Found> {
    let row = sqlx::query_as(concat!("SELECT ", job_columns!(), " FROM jobs WHERE id = $1 AND tenant = $2"));
    let row: Option<JobRow> = row.bind(job).bind(tenant.as_str()).fetch_optional(&mut *db).await?;
    let Some(row) = row else { return Ok(Found::default()) };
    let mut found = Found::of_job(Versioned::job(&row.into()));
    let rows = &mut found;
    all::<FoundIteration>(
        db,
        "SELECT number, id, flank, tooth, axes, measured_at, instrument, operator, note, created_at
         FROM iterations WHERE job = $1 ORDER BY number",
        job,
        rows,
    )
    .await?;
    all::<FoundNodes>(db, "SELECT number, count, data FROM nodes WHERE job = $1 ORDER BY number", job, rows).await?;
    all::<FoundFitTold>(
        db,
        concat!(
            "SELECT number, id, reason, actor, created_at, ",
            figure_columns!(),
            ", spec, result, flank_figures, coefficients, prior
             FROM fits WHERE job = $1 ORDER BY number, position"
        ),
        job,
        rows,
    )
    .await?;
    all::<ChoiceRow>(
        db,
        "SELECT c.number, f.id AS fit_id, c.reason, c.actor, c.created_at
         FROM fit_choices c JOIN fits f ON f.job = c.job AND f.number = c.number AND f.position = c.fit
         WHERE c.job = $1 ORDER BY c.number, c.position",
        job,
        rows,
    )
    .await?;
    all::<DecisionRow>(
        db,
        "SELECT number, decision, concession, reason, actor, created_at FROM decisions WHERE job = $1
         ORDER BY number, position",
        job,
        rows,
    )
    .await?;
    all::<RecordRow>(
        db,
        "SELECT number, id, kind, method, created_at, actor, request, result, gear, class, measurand
         FROM records WHERE job = $1 ORDER BY number, position",
        job,
        rows,
    )
    .await?;
    own(db, job, &mut found).await?;
    Ok(found)
}

/// Adds its purge and the rows of its streams.
async fn own(db: &mut PgConnection, job: Uuid, found: &mut Found) -> Outcome<()> {
    let purge = sqlx::query(
        "SELECT j.purged_at, p.at, p.reason, p.archive_sha256
         FROM jobs j LEFT JOIN purges p ON p.job = j.id WHERE j.id = $1",
    );
    let purge = purge.bind(job).fetch_optional(&mut *db).await?;
    found.purge = purge.and_then(|row| FoundJobPurge::from_row(&row).map_or(Some([0; 32]), |found| found.digest(job)));
    let mut streams = sqlx::query_as::<_, FoundStreamRow>(
        "SELECT id, spec, forgetting_factor, flank, tooth, axes, created_at, iteration IS NULL AS open
         FROM streams WHERE job = $1",
    )
    .bind(job)
    .fetch(&mut *db);
    while let Some(row) = streams.try_next().await? {
        let (id, stream) = row.into();
        found.streams.insert(id, stream);
    }
    drop(streams);
    let mut blocks = sqlx::query_as::<_, FoundBlock>(
        "SELECT b.stream, b.sequence, b.sha256, b.count, b.data
         FROM streams s JOIN stream_blocks b ON b.stream = s.id WHERE s.job = $1",
    )
    .bind(job)
    .fetch(db);
    while let Some(row) = blocks.try_next().await? {
        let (block, digest) = row.into();
        found.blocks.insert(block, digest);
    }
    Ok(())
}

/// Adds the rows of a kind, in order. One that does not read is none that an entry tells of.
async fn all<T>(db: &mut PgConnection, sql: &'static str, job: Uuid, found: &mut Found) -> Outcome<()>
where
    T: FoundRow + for<'r> FromRow<'r, PgRow>,
{
    let mut rows = sqlx::query(sql).bind(job).fetch(db);
    while let Some(row) = rows.try_next().await? {
        let number: i64 = row.try_get("number")?;
        let digest = T::from_row(&row).map_or([0; 32], FoundRow::digest);
        found.add(number.unsigned_abs(), T::KIND, digest);
    }
    Ok(())
}
