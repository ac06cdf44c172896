//! Streams: from their opening to the iteration that they become.

use sqlx::{PgConnection, PgPool};
use uuid::Uuid;

use super::{
    document::encode,
    gone,
    locate::{self, signed},
    open::snapshot,
    session::Session,
    time::stamp,
};
use crate::{
    jobs::{
        Caller, Cursor, JobGear, Page, PageRequest, RepositoryError, Resource, Stored, Stream, Tenant, audit::Action,
    },
    store::shared::{
        Asked, DeleteStream, FinishStream, GetStream, Incoming, InsertStream, InsertTogether as _, Integer, JobPurge,
        ListStreams, Outcome, Read, StreamRow, Write, target,
    },
};

/// What is read of streams.
macro_rules! stream_columns {
    () => {
        "s.id, s.job AS job_id, s.spec, s.forgetting_factor, s.sequence, s.node_count, s.input_sha256, s.flank, s.tooth,
         s.axes, s.iteration, s.version, s.created_at, s.updated_at"
    };
}

/// A stream.
pub async fn located(db: &mut PgConnection, tenant: &Tenant, id: Uuid) -> Outcome<Stream> {
    let found: Option<StreamRow> = sqlx::query_as(concat!(
        "SELECT ",
        stream_columns!(),
        " FROM streams s JOIN jobs j ON j.id = s.job WHERE s.id = $1 AND j.tenant = $2"
    ))
    .bind(id)
    .bind(tenant.as_str())
    .fetch_optional(&mut *db)
    .await?;
    let row = found.ok_or(RepositoryError::NotFound(Resource::Stream))?;
    match row.is_gone() {
        Some(job) => Err(gone::told(db, job).await),
        None => Ok(row.into()),
    }
}

impl Read<PgPool> for GetStream {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Stream> {
        let mut db = from.acquire().await?;
        located(&mut db, &caller.tenant, self.id).await
    }
}

impl Read<PgPool> for ListStreams {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Page<Stream>> {
        let PageRequest { limit, after } = self.page;
        let mut db = snapshot(from).await?;
        locate::job(&mut db, &caller.tenant, self.job).await?;
        let rows: Vec<StreamRow> = sqlx::query_as(concat!(
            "SELECT ",
            stream_columns!(),
            " FROM streams s WHERE s.job = $1 AND s.id > $2 ORDER BY s.id LIMIT $3"
        ))
        .bind(self.job)
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
        gear: Option<String>,
    }
}

impl Write<Session> for InsertStream {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Stored> {
        let (InsertStream { stream, receipt }, tenant) = (&asked.write, asked.tenant());
        let JobOfStream { gear, purge } = sqlx::query_as(
            "SELECT gear, purged_at, (SELECT reason FROM purges WHERE job = id) AS purge_reason
             FROM jobs WHERE id = $1 AND tenant = $2",
        )
        .bind(stream.job_id)
        .bind(tenant.as_str())
        .fetch_optional(&mut session.db)
        .await?
        .ok_or(RepositoryError::NotFound(Resource::Job))?;
        purge.refuse()?;
        session.keys.refuse_taken(tenant, receipt.as_ref())?;
        stream.measurand.check_tooth(gear.map(JobGear::from).as_ref().and_then(JobGear::teeth))?;
        session.enter(asked, stream.job_id, Action::OpenStream, target::stream(stream.id)).await?;
        sqlx::query(
            "INSERT INTO streams (id, job, spec, forgetting_factor, sequence, node_count, input_sha256, version,
                                  created_at, updated_at, flank, tooth, axes)
             VALUES ($1, $2, $3, $4, 0, 0, $5, 1, $6, $6, $7, $8, $9)",
        )
        .bind(stream.id)
        .bind(stream.job_id)
        .bind(encode(&stream.spec))
        .bind(stream.forgetting_factor)
        .bind(stream.input_sha256.as_slice())
        .bind(stamp(stream.created_at))
        .bind(stream.measurand.flank_name())
        .bind(stream.measurand.tooth.as_deref())
        .bind(stream.measurand.axes.as_deref())
        .execute(&mut session.db)
        .await?;
        let stored = Stored { number: 0, version: 1 };
        session.keys.keep(tenant, receipt.as_ref(), stored, stream.created_at, None);
        Ok(stored)
    }
}

impl Write<Session> for FinishStream {
    /// The iteration is inserted as any other; the blocks go, since the iteration holds the nodes.
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Stored> {
        let (FinishStream { finished, receipt }, tenant) = (&asked.write, asked.tenant());
        let stream = located(&mut session.db, tenant, finished.stream).await?;
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
        let mut stored = session.insert(&[incoming]).await?;
        let stored = stored.pop().unwrap_or(Err(RepositoryError::NotFound(Resource::Job)))?;
        sqlx::query("UPDATE streams SET version = $1, updated_at = $2, iteration = $3 WHERE id = $4")
            .bind(signed(stream.version + 1))
            .bind(stamp(finished.iteration.created_at))
            .bind(i64::from(stored.number))
            .bind(stream.id)
            .execute(&mut session.db)
            .await?;
        delete_blocks(&mut session.db, stream.id).await?;
        Ok(stored)
    }
}

impl Write<Session> for DeleteStream {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<()> {
        let DeleteStream { id, precondition, now } = &asked.write;
        let stream = located(&mut session.db, asked.tenant(), *id).await?;
        precondition.check(stream.version)?;
        session.enter(asked, stream.job_id, Action::DeleteStream, target::stream(*id)).await?;
        let db = &mut session.db;
        delete_blocks(db, *id).await?;
        // the event of the deletion carries this time
        sqlx::query("UPDATE streams SET updated_at = $1 WHERE id = $2")
            .bind(stamp(*now))
            .bind(*id)
            .execute(&mut *db)
            .await?;
        sqlx::query("DELETE FROM streams WHERE id = $1").bind(*id).execute(db).await?;
        Ok(())
    }
}

async fn delete_blocks(db: &mut PgConnection, stream: Uuid) -> Outcome<()> {
    sqlx::query("DELETE FROM stream_states WHERE stream = $1").bind(stream).execute(&mut *db).await?;
    sqlx::query("DELETE FROM stream_blocks WHERE stream = $1").bind(stream).execute(db).await?;
    Ok(())
}

/// Refuses to delete a job with streams; takes the events of one without anything along.
pub async fn release_job(db: &mut PgConnection, job: Uuid) -> Outcome<()> {
    let streams: Integer<u64> =
        sqlx::query_scalar("SELECT count(*) FROM streams WHERE job = $1").bind(job).fetch_one(&mut *db).await?;
    if streams.0 > 0 {
        return Err(RepositoryError::HasStreams(streams.0).into());
    }
    sqlx::query("DELETE FROM events WHERE job = $1").bind(job).execute(db).await?;
    Ok(())
}
