//! Streams: from their opening to the iteration that they become.

use sqlx::{SqliteConnection, SqlitePool};
use uuid::Uuid;

use super::{
    answers, audit, gone, insert_iterations,
    locate::{self, WithSeq, signed},
    time,
};
use crate::{
    jobs::{
        Caller, Cursor, JobGear, Page, PageRequest, RepositoryError, Resource, Stored, Stream, Tenant, audit::Action,
    },
    store::shared::{
        Asked, DeleteStream, FinishStream, GetStream, Incoming, InsertStream, Integer, JobPurge, ListStreams, Outcome,
        Read, StreamRow, Write, target,
    },
};

/// What is read of streams, and where it stands.
macro_rules! stream_columns {
    () => {
        "s.id AS id, j.id AS job_id, s.spec AS spec, s.forgetting_factor AS forgetting_factor,
         s.sequence AS sequence, s.node_count AS node_count, s.input_sha256 AS input_sha256,
         s.flank AS flank, s.tooth AS tooth, s.axes AS axes, i.number AS iteration, s.version AS version,
         s.created_at AS created_at, s.updated_at AS updated_at
         FROM streams s JOIN jobs j ON j.seq = s.job LEFT JOIN iterations i ON i.seq = s.iteration"
    };
}

/// A stream with its row.
pub async fn located(db: &mut SqliteConnection, tenant: &Tenant, id: Uuid) -> Outcome<(i64, Stream)> {
    let found: Option<WithSeq<StreamRow>> =
        sqlx::query_as(concat!("SELECT s.seq AS seq, ", stream_columns!(), " WHERE s.id = ? AND j.tenant = ?"))
            .bind(id)
            .bind(tenant.as_str())
            .fetch_optional(&mut *db)
            .await?;
    let WithSeq { seq, row } = found.ok_or(RepositoryError::NotFound(Resource::Stream))?;
    match row.is_gone() {
        Some(job) => Err(gone::told(db, job).await),
        None => Ok((seq, row.into())),
    }
}

impl Read<SqlitePool> for GetStream {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Stream> {
        let mut db = from.acquire().await?;
        Ok(located(&mut db, &caller.tenant, self.id).await?.1)
    }
}

impl Read<SqlitePool> for ListStreams {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Page<Stream>> {
        let PageRequest { limit, after } = self.page;
        let mut db = from.begin().await?;
        let job = locate::job(&mut db, &caller.tenant, self.job).await?;
        let rows: Vec<StreamRow> = sqlx::query_as(concat!(
            "SELECT ",
            stream_columns!(),
            " WHERE s.job = ? AND s.id > ? ORDER BY s.id LIMIT ?"
        ))
        .bind(job)
        .bind(after.map_or(Uuid::nil(), |Cursor(id)| id))
        .bind(i64::from(limit) + 1)
        .fetch_all(&mut *db)
        .await?;
        match rows.iter().find_map(StreamRow::is_gone) {
            Some(job) => Err(gone::told(&mut db, job).await),
            None => Ok(Page::of(rows.into_iter().map(Stream::from).collect(), limit, |stream| Cursor(stream.id))),
        }
    }
}

row! {
    struct JobOfStream {
        @purge: JobPurge,
        seq: i64,
        gear: Option<String>,
    }
}

impl Write<SqliteConnection> for InsertStream {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Stored> {
        let (InsertStream { stream, receipt }, tenant) = (&asked.write, asked.tenant());
        let job: JobOfStream = sqlx::query_as(
            "SELECT seq, gear, purged_at, (SELECT reason FROM purges WHERE job = seq) AS purge_reason
             FROM jobs WHERE id = ? AND tenant = ?",
        )
        .bind(stream.job_id)
        .bind(tenant.as_str())
        .fetch_optional(&mut *db)
        .await?
        .ok_or(RepositoryError::NotFound(Resource::Job))?;
        job.purge.refuse()?;
        answers::refuse_taken(db, tenant, receipt.as_ref()).await?;
        stream.measurand.check_tooth(job.gear.map(JobGear::from).as_ref().and_then(JobGear::teeth))?;
        let mut chain = audit::of_job(db, asked.by(), stream.job_id).await?;
        let at = time::to_text(stream.created_at);
        sqlx::query(
            "INSERT INTO streams (id, job, spec, forgetting_factor, sequence, node_count, input_sha256, version,
                                  created_at, updated_at, flank, tooth, axes)
             VALUES (?, ?, ?, ?, 0, 0, ?, 1, ?, ?, ?, ?, ?)",
        )
        .bind(stream.id)
        .bind(job.seq)
        .bind(stream.spec.clone())
        .bind(stream.forgetting_factor)
        .bind(stream.input_sha256.as_slice())
        .bind(at.as_str())
        .bind(at.as_str())
        .bind(stream.measurand.flank_name())
        .bind(stream.measurand.tooth.as_deref())
        .bind(stream.measurand.axes.clone())
        .execute(&mut *db)
        .await?;
        asked.enter(&mut chain, Action::OpenStream, target::stream(stream.id));
        audit::store(db, chain).await?;
        let stored = Stored { number: 0, version: 1 };
        answers::keep(db, tenant, receipt.as_ref(), stored, stream.created_at, None).await?;
        Ok(stored)
    }
}

impl Write<SqliteConnection> for FinishStream {
    /// The iteration is inserted as any other; the blocks go, since the iteration holds the nodes.
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Stored> {
        let (FinishStream { finished, receipt }, tenant) = (&asked.write, asked.tenant());
        let (seq, stream) = located(db, tenant, finished.stream).await?;
        stream.check_open()?;
        if finished.sequence != stream.sequence {
            return Err(RepositoryError::UnexpectedBlock { expected: stream.expected() }.into());
        }
        let incoming = Incoming {
            by: asked.by(),
            iteration: &finished.iteration,
            receipt: receipt.as_ref(),
            prepared: &asked.prepared[0],
            stream: Some(stream.id),
        };
        let mut stored = insert_iterations::insert(db, &[incoming]).await?;
        let stored = stored.pop().unwrap_or(Err(RepositoryError::NotFound(Resource::Job)))?;
        sqlx::query(
            "UPDATE streams SET version = ?, updated_at = ?, iteration =
             (SELECT i.seq FROM iterations i WHERE i.job = streams.job AND i.number = ?) WHERE seq = ?",
        )
        .bind(signed(stream.version + 1))
        .bind(time::to_text(finished.iteration.created_at))
        .bind(stored.number)
        .bind(seq)
        .execute(&mut *db)
        .await?;
        delete_blocks(db, seq).await?;
        Ok(stored)
    }
}

impl Write<SqliteConnection> for DeleteStream {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<()> {
        let DeleteStream { id, precondition, now } = &asked.write;
        let (seq, stream) = located(db, asked.tenant(), *id).await?;
        precondition.check(stream.version)?;
        let mut chain = audit::of_job(db, asked.by(), stream.job_id).await?;
        delete_blocks(db, seq).await?;
        // the event of the deletion carries this time
        sqlx::query("UPDATE streams SET updated_at = ? WHERE seq = ?")
            .bind(time::to_text(*now))
            .bind(seq)
            .execute(&mut *db)
            .await?;
        sqlx::query("DELETE FROM streams WHERE seq = ?").bind(seq).execute(&mut *db).await?;
        asked.enter(&mut chain, Action::DeleteStream, target::stream(*id));
        audit::store(db, chain).await?;
        Ok(())
    }
}

async fn delete_blocks(db: &mut SqliteConnection, stream: i64) -> Outcome<()> {
    sqlx::query("DELETE FROM stream_states WHERE stream = ?").bind(stream).execute(&mut *db).await?;
    sqlx::query("DELETE FROM stream_blocks WHERE stream = ?").bind(stream).execute(db).await?;
    Ok(())
}

/// Refuses to delete a job with streams; takes the events of one without anything along.
pub async fn release_job(db: &mut SqliteConnection, job: i64) -> Outcome<()> {
    let streams: Integer<u64> =
        sqlx::query_scalar("SELECT count(*) FROM streams WHERE job = ?").bind(job).fetch_one(&mut *db).await?;
    if streams.0 > 0 {
        return Err(RepositoryError::HasStreams(streams.0).into());
    }
    sqlx::query("DELETE FROM events WHERE job = ?").bind(job).execute(db).await?;
    Ok(())
}
