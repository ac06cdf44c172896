//! Streams: from their opening to the iteration that they become.

use super::{gone, incoming::Incoming, insert_iterations, locate, prelude::*, subject};

from_row! {
    Stream {
        @measurand,
        id, job_id, spec, forgetting_factor, sequence, node_count, input_sha256, iteration, version, created_at,
        updated_at,
    }
}

/// The columns of a [`Stream`].
macro_rules! stream_columns {
    () => {
        "s.id AS id, s.job AS job_id, s.spec AS spec, s.forgetting_factor AS forgetting_factor,
         s.sequence AS sequence, s.node_count AS node_count, s.input_sha256 AS input_sha256, s.flank AS flank,
         s.tooth AS tooth, s.axes AS axes, false AS accept_units, s.iteration AS iteration, s.version AS version,
         s.created_at AS created_at, s.updated_at AS updated_at"
    };
}

/// Returns a stream of a tenant.
pub async fn located(db: &mut Db, tenant: &Tenant, id: Uuid) -> Outcome<Stream> {
    let sql = concat!(
        "SELECT ",
        stream_columns!(),
        " FROM streams s JOIN jobs j ON j.id = s.job WHERE s.id = $1 AND j.tenant = $2"
    );
    let stream: Option<Stream> = db.maybe(sql, args![id, tenant]).await?;
    match stream.ok_or(RepositoryError::NotFound(Resource::Stream))? {
        stream if stream.spec.is_empty() => Err(gone::refusal(db, stream.job_id).await),
        stream => Ok(stream),
    }
}

pub async fn stream(db: &mut Db, caller: &Caller, id: &Uuid) -> Outcome<Stream> {
    located(db, &caller.tenant, *id).await
}

pub async fn streams(db: &mut Db, caller: &Caller, job: &Uuid, page: &PageRequest) -> Outcome<Page<Stream>> {
    let PageRequest { limit, after } = *page;
    locate::job(db, &caller.tenant, *job).await?;
    let sql =
        concat!("SELECT ", stream_columns!(), " FROM streams s WHERE s.job = $1 AND s.id > $2 ORDER BY s.id LIMIT $3");
    let after = after.map_or(Uuid::nil(), |Cursor(id)| id);
    let streams: Vec<Stream> = db.all(sql, args![job, after, i64::from(limit) + 1]).await?;
    match streams.iter().any(|stream| stream.spec.is_empty()) {
        true => Err(gone::refusal(db, *job).await),
        false => Ok(Page::of(streams, limit, |stream| Cursor(stream.id))),
    }
}

row! {
    struct JobOfStream {
        @purge: JobPurge,
        gear: Option<JobGear>,
    }
}

pub async fn insert_stream(tx: &mut Tx<'_>, write: &InsertStream) -> Outcome<Stored> {
    let (stream, tenant) = (&write.stream, tx.tenant());
    let sql = "SELECT gear, purged_at, (SELECT reason FROM purges WHERE job = id) AS purge_reason
               FROM jobs WHERE id = $1 AND tenant = $2";
    let job: Option<JobOfStream> = tx.db().maybe(sql, args![stream.job_id, tenant]).await?;
    let JobOfStream { purge, gear } = job.ok_or(RepositoryError::NotFound(Resource::Job))?;
    purge.refuse()?;
    tx.refuse_taken()?;
    stream.measurand.check_tooth(gear.as_ref().and_then(JobGear::teeth))?;
    let mut entry = tx.draft(stream.job_id, Action::OpenStream, subject::stream(stream.id))?;
    let db = tx.db();
    db.run(
        "INSERT INTO streams (id, job, spec, forgetting_factor, sequence, node_count, input_sha256, version,
                                  created_at, updated_at, flank, tooth, axes)
             VALUES ($1, $2, $3, $4, 0, 0, $5, 1, $6, $6, $7, $8, $9)",
        args![
            stream.id,
            stream.job_id,
            Value::document(&stream.spec),
            stream.forgetting_factor,
            &stream.input_sha256,
            stream.created_at,
            stream.measurand.flank_name(),
            stream.measurand.tooth.as_deref(),
            stream.measurand.axes.as_deref(),
        ],
    )
    .await?;
    entry.note_stored(db, "streams", "id = $1", args![stream.id]).await?;
    entry.note_event(db, stream.job_id).await?;
    tx.enter(entry);
    Ok(tx.keep(&write.receipt, Stored { number: 0, version: 1 }, None, stream.created_at))
}

/// The iteration is inserted like any other; the blocks go, since the iteration holds the
/// nodes.
pub async fn finish_stream(tx: &mut Tx<'_>, write: &FinishStream) -> Outcome<Stored> {
    let (finished, tenant) = (&write.finished, tx.tenant());
    let stream = located(tx.db(), tenant, finished.stream).await?;
    stream.check_open()?;
    if finished.sequence != stream.sequence {
        return Err(RepositoryError::UnexpectedBlock { expected: stream.expected() }.into());
    }
    let incoming =
        Incoming { stream: Some(stream.id), ..Incoming::of(tx.request, &finished.iteration, write.receipt.as_ref()) };
    let stored = insert_iterations::one(tx.session, incoming).await?;
    let version = stream.version + 1;
    tx.db()
        .run(
            "UPDATE streams SET version = $1, updated_at = $2, iteration = $3 WHERE id = $4",
            args![version, finished.iteration.created_at, stored.number, stream.id],
        )
        .await?;
    let Tx { session, .. } = tx;
    delete_blocks(&mut session.db, stream.id).await?;
    // that of its iteration
    if let Some(entry) = session.entries.last_mut() {
        entry.note_stored(&mut session.db, "streams", "id = $1", args![stream.id]).await?;
        entry.note_event(&mut session.db, stream.job_id).await?;
    }
    Ok(stored)
}

pub async fn delete_stream(tx: &mut Tx<'_>, write: &DeleteStream) -> Outcome<()> {
    let tenant = tx.tenant();
    let stream = located(tx.db(), tenant, write.id).await?;
    write.precondition.check(stream.version)?;
    let mut entry = tx.draft(stream.job_id, Action::DeleteStream, subject::stream(write.id))?;
    let db = tx.db();
    delete_blocks(db, write.id).await?;
    // the event of the deletion has this time
    db.run("UPDATE streams SET updated_at = $1 WHERE id = $2", args![write.now, write.id]).await?;
    db.run("DELETE FROM streams WHERE id = $1", args![write.id]).await?;
    entry.note_event(db, stream.job_id).await?;
    tx.enter(entry);
    Ok(())
}

async fn delete_blocks(db: &mut Db, stream: Uuid) -> Outcome<()> {
    db.run("DELETE FROM stream_states WHERE stream = $1", args![stream]).await?;
    db.run("DELETE FROM stream_blocks WHERE stream = $1", args![stream]).await?;
    Ok(())
}

/// Refuses to delete a job with streams; deletes the events of a job that has nothing else.
pub async fn release_job(db: &mut Db, job: Uuid) -> Outcome<()> {
    let streams: u64 = db.one("SELECT count(*) FROM streams WHERE job = $1", args![job]).await?;
    if streams > 0 {
        return Err(RepositoryError::HasStreams(streams).into());
    }
    db.run("DELETE FROM events WHERE job = $1", args![job]).await?;
    Ok(())
}
