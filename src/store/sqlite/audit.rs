//! The entries of the audit, and the rows that they have digests of.

use futures_util::TryStreamExt as _;
use sqlx::{FromRow, Row as _, Sqlite, SqliteConnection, query::Query, sqlite::SqliteArguments, sqlite::SqliteRow};
use uuid::Uuid;

use super::{locate::signed, time};
use crate::{
    jobs::{
        Tenant,
        audit::{By, Chain, Found, Versioned},
    },
    store::shared::{
        ChoiceRow, DecisionRow, FoundBlock, FoundFitTold, FoundIteration, FoundJobPurge, FoundNodes, FoundRow,
        FoundStreamRow, Growing, HeadRow, JobRow, NewEntry, Outcome, RecordRow, figure_columns, job_columns,
    },
};

/// The columns of an entry that [`bind`] gives values, in its order.
macro_rules! columns {
    () => {
        "tenant, chain, number, id, at, actor, action, target, request_id, peer, contents, outcome, previous, sha256"
    };
}
pub(super) use columns;

/// Binds the [`columns`] of an entry.
pub fn bind<'q>(query: Query<'q, Sqlite, SqliteArguments>, new: &'q NewEntry) -> Query<'q, Sqlite, SqliteArguments> {
    let NewEntry { tenant, chain, entry } = new;
    query
        .bind(tenant.as_str())
        .bind(*chain)
        .bind(signed(entry.number))
        .bind(entry.id)
        .bind(time::to_text(entry.at))
        .bind(&*entry.actor)
        .bind(&*entry.action)
        .bind(entry.target.as_str())
        .bind(entry.request_id.as_deref())
        .bind(entry.peer.as_deref())
        .bind(entry.contents.bytes())
        .bind(&*entry.outcome)
        .bind(entry.previous.as_slice())
        .bind(entry.sha256.as_slice())
}

/// The chain of a job that there is, to add to it. It is asked for before the job is changed: one
/// that has none yet begins with what is found now.
pub async fn of_job(db: &mut SqliteConnection, by: By<'_>, job: Uuid) -> Outcome<Growing> {
    match head(db, job).await? {
        Some(head) => Ok(Growing::from(&by.caller.tenant, Chain::Job(job), Some(head.into()))),
        None => Ok(Growing::begin(by, job, &found(db, &by.caller.tenant, job).await?)),
    }
}

/// The last entry of a chain.
pub async fn head(db: &mut SqliteConnection, chain: Uuid) -> Outcome<Option<HeadRow>> {
    let head = sqlx::query_as("SELECT number, sha256 FROM audit WHERE chain = ? ORDER BY number DESC LIMIT 1");
    Ok(head.bind(chain).fetch_optional(db).await?)
}

/// Stores what was added to a chain.
pub async fn store(db: &mut SqliteConnection, chain: Growing) -> Outcome<()> {
    for new in &chain.new {
        let insert = concat!("INSERT INTO audit (", columns!(), ") VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
        bind(sqlx::query(insert), new).execute(&mut *db).await?;
    }
    Ok(())
}

/// The rows of a job of a tenant; none of another's, which for this one does not exist.
pub async fn found(db: &mut SqliteConnection, tenant: &Tenant, job: Uuid) -> Outcome<Found> {
    let row = sqlx::query_as(concat!("SELECT ", job_columns!(), " FROM jobs WHERE id = ? AND tenant = ?"));
    let row: Option<JobRow> = row.bind(job).bind(tenant.as_str()).fetch_optional(&mut *db).await?;
    let Some(row) = row else { return Ok(Found::default()) };
    let mut found = Found::of_job(Versioned::job(&row.into()));
    let rows = &mut found;
    all::<FoundIteration>(
        db,
        "SELECT i.number AS number, i.id AS id, i.flank AS flank, i.tooth AS tooth, i.axes AS axes,
                i.measured_at AS measured_at, i.instrument AS instrument, i.operator AS operator, i.note AS note,
                i.created_at AS created_at
         FROM jobs j JOIN iterations i ON i.job = j.seq WHERE j.id = ? ORDER BY i.number",
        job,
        rows,
    )
    .await?;
    all::<FoundNodes>(
        db,
        "SELECT i.number AS number, n.count AS count, n.data AS data
         FROM jobs j JOIN iterations i ON i.job = j.seq JOIN nodes n ON n.iteration = i.seq
         WHERE j.id = ? ORDER BY i.number",
        job,
        rows,
    )
    .await?;
    all::<FoundFitTold>(
        db,
        concat!(
            "SELECT (SELECT number FROM iterations WHERE seq = iteration) AS number, id, reason, actor, created_at, ",
            figure_columns!(),
            ", spec, coalesce(frame, result) AS result, flank_figures, coefficients, prior FROM fits
             WHERE iteration IN (SELECT i.seq FROM jobs j JOIN iterations i ON i.job = j.seq WHERE j.id = ?)
             ORDER BY iteration, seq"
        ),
        job,
        rows,
    )
    .await?;
    all::<ChoiceRow>(
        db,
        "SELECT i.number AS number, f.id AS fit_id, c.reason AS reason, c.actor AS actor,
                c.created_at AS created_at
         FROM jobs j JOIN iterations i ON i.job = j.seq JOIN fit_choices c ON c.iteration = i.seq
              JOIN fits f ON f.seq = c.fit
         WHERE j.id = ? ORDER BY i.number, c.position",
        job,
        rows,
    )
    .await?;
    all::<DecisionRow>(
        db,
        "SELECT i.number AS number, d.decision AS decision, d.concession AS concession, d.reason AS reason, d.actor AS actor,
                d.created_at AS created_at
         FROM jobs j JOIN iterations i ON i.job = j.seq JOIN decisions d ON d.iteration = i.seq
         WHERE j.id = ? ORDER BY i.number, d.position",
        job,
        rows,
    )
    .await?;
    all::<RecordRow>(
        db,
        "SELECT i.number AS number, r.id AS id, r.kind AS kind, r.method AS method, r.created_at AS created_at,
                r.actor AS actor, r.request AS request, r.result AS result, r.gear AS gear, r.class AS class,
                r.measurand AS measurand
         FROM jobs j JOIN iterations i ON i.job = j.seq JOIN records r ON r.iteration = i.seq
         WHERE j.id = ? ORDER BY i.number, r.seq",
        job,
        rows,
    )
    .await?;
    own(db, job, &mut found).await?;
    Ok(found)
}

/// Adds its purge and the rows of its streams.
async fn own(db: &mut SqliteConnection, job: Uuid, found: &mut Found) -> Outcome<()> {
    let purge = sqlx::query(
        "SELECT j.purged_at AS purged_at, p.at AS at, p.reason AS reason, p.archive_sha256 AS archive_sha256
         FROM jobs j LEFT JOIN purges p ON p.job = j.seq WHERE j.id = ?",
    );
    let purge = purge.bind(job).fetch_optional(&mut *db).await?;
    found.purge = purge.and_then(|row| FoundJobPurge::from_row(&row).map_or(Some([0; 32]), |found| found.digest(job)));
    let mut streams = sqlx::query_as::<_, FoundStreamRow>(
        "SELECT s.id AS id, s.spec AS spec, s.forgetting_factor AS forgetting_factor, s.flank AS flank,
                s.tooth AS tooth, s.axes AS axes, s.created_at AS created_at, s.iteration IS NULL AS open
         FROM jobs j JOIN streams s ON s.job = j.seq WHERE j.id = ?",
    )
    .bind(job)
    .fetch(&mut *db);
    while let Some(row) = streams.try_next().await? {
        let (id, stream) = row.into();
        found.streams.insert(id, stream);
    }
    drop(streams);
    let mut blocks = sqlx::query_as::<_, FoundBlock>(
        "SELECT s.id AS stream, b.sequence AS sequence, b.sha256 AS sha256, b.count AS count, b.data AS data
         FROM jobs j JOIN streams s ON s.job = j.seq JOIN stream_blocks b ON b.stream = s.seq WHERE j.id = ?",
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
async fn all<T>(db: &mut SqliteConnection, sql: &'static str, job: Uuid, found: &mut Found) -> Outcome<()>
where
    T: FoundRow + for<'r> FromRow<'r, SqliteRow>,
{
    let mut rows = sqlx::query(sql).bind(job).fetch(db);
    while let Some(row) = rows.try_next().await? {
        let number: i64 = row.try_get("number")?;
        let digest = T::from_row(&row).map_or([0; 32], FoundRow::digest);
        found.add(number.unsigned_abs(), T::KIND, digest);
    }
    Ok(())
}
