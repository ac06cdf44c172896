//! Streams and events: their reads, and their writes inside a transaction that the writer has
//! begun.

use jiff::Timestamp;
use sqlx::{Row, SqliteConnection, SqlitePool};
use uuid::Uuid;

use super::{
    bulk::{self, Incoming},
    error::failure,
    rows::{self, damaged, get},
    time,
    write::{WriteError, keep_answer, refuse_taken_key, signed},
};
use crate::{
    api::gears::gear::stored_teeth,
    jobs::{
        Block, Happening, JobEvent, NewBlock, NewStream, Precondition, Receipt, RepositoryError, Stored, Stream,
        StreamEvent, StreamState, What, nodes_codec,
    },
};

type Read<T> = Result<T, RepositoryError>;
type Written<T> = Result<T, WriteError>;

/// Bytes of blocks that are read at a time, beyond the first block.
const BYTES_AT_A_TIME: i64 = 8 << 20;
/// Blocks that are read at a time.
const BLOCKS_AT_A_TIME: i64 = 1024;

/// A block on its way in.
pub struct IncomingBlock {
    pub block: std::sync::Arc<NewBlock>,
    /// [`nodes_codec::encode`] of its nodes.
    pub nodes: Vec<u8>,
    pub receipt: Option<Receipt>,
}

/// A stream on its way to become an iteration.
pub struct IncomingFinish {
    pub stream: Uuid,
    pub sequence: u64,
    pub incoming: Incoming,
}

macro_rules! stream_columns {
    () => {
        "s.id, j.id, s.spec, s.forgetting_factor, s.sequence, s.node_count, s.input_sha256, i.number, s.version, \
         s.created_at,
         s.updated_at, s.seq, s.job, s.flank, s.tooth, s.axes FROM streams s JOIN jobs j ON j.seq = s.job LEFT JOIN \
         iterations i ON i.seq = s.iteration"
    };
}

fn read_stream(row: &sqlx::sqlite::SqliteRow) -> Read<Stream> {
    Ok(Stream {
        id: get(row, 0)?,
        job_id: get(row, 1)?,
        spec: get::<String>(row, 2)?.into(),
        forgetting_factor: get(row, 3)?,
        sequence: rows::unsigned(row, 4)?,
        node_count: rows::unsigned(row, 5)?,
        input_sha256: digest(row, 6)?,
        measurand: rows::measurand(row, 13)?,
        iteration: get::<Option<u32>>(row, 7)?,
        version: rows::unsigned(row, 8)?,
        created_at: rows::moment(row, 9)?,
        updated_at: rows::moment(row, 10)?,
    })
}

fn digest(row: &sqlx::sqlite::SqliteRow, at: usize) -> Read<[u8; 32]> {
    get::<&[u8]>(row, at)?.try_into().map_err(|_| damaged("a digest", "of another length"))
}

#[expect(clippy::needless_pass_by_value, reason = "the form that map_err takes")]
fn sql(error: sqlx::Error) -> RepositoryError {
    failure(&error)
}

/// The stream with the rows of itself and of its job.
async fn stream_row(db: &mut SqliteConnection, id: Uuid) -> Written<(Stream, i64)> {
    let row = sqlx::query(concat!("SELECT ", stream_columns!(), " WHERE s.id = ?"))
        .bind(id)
        .fetch_optional(&mut *db)
        .await?
        .ok_or(RepositoryError::NotFound(What::Stream))?;
    Ok((read_stream(&row)?, row.try_get(11)?))
}

pub async fn insert_stream(
    db: &mut SqliteConnection,
    stream: &NewStream,
    receipt: Option<&Receipt>,
) -> Written<Stored> {
    let row = sqlx::query("SELECT seq, gear FROM jobs WHERE id = ?")
        .bind(stream.job_id)
        .fetch_optional(&mut *db)
        .await?
        .ok_or(RepositoryError::NotFound(What::Job))?;
    let job: i64 = row.try_get(0)?;
    refuse_taken_key(db, receipt).await?;
    stream.measurand.check_tooth(row.try_get::<Option<&str>, _>(1)?.and_then(stored_teeth))?;
    let at = time::to_text(stream.created_at);
    sqlx::query(
        "INSERT INTO streams (id, job, spec, forgetting_factor, sequence, node_count, input_sha256, version, \
         created_at, updated_at,
                              flank, tooth, axes)
         VALUES (?, ?, ?, ?, 0, 0, ?, 1, ?, ?, ?, ?, ?)",
    )
    .bind(stream.id)
    .bind(job)
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
    let stored = Stored { number: 0, version: 1 };
    keep_answer(db, receipt, stored, stream.created_at).await?;
    Ok(stored)
}

pub async fn insert_block(db: &mut SqliteConnection, incoming: &IncomingBlock) -> Written<Stored> {
    let IncomingBlock { block, nodes, receipt } = incoming;
    let (stream, seq) = stream_row(db, block.stream).await?;
    if let Some(iteration) = stream.iteration {
        return Err(RepositoryError::StreamFinished { iteration }.into());
    }
    if block.sequence != stream.sequence + 1 {
        return Err(RepositoryError::UnexpectedBlock { expected: stream.sequence + 1 }.into());
    }
    refuse_taken_key(db, receipt.as_ref()).await?;
    let posted = block.nodes.posted() as u64;
    let at = time::to_text(block.created_at);
    sqlx::query(
        "INSERT INTO stream_blocks (stream, sequence, sha256, count, data, created_at) VALUES (?, ?, ?, ?, ?, ?)",
    )
    .bind(seq)
    .bind(signed(block.sequence))
    .bind(block.sha256.as_slice())
    .bind(signed(posted))
    .bind(nodes.as_slice())
    .bind(at.as_str())
    .execute(&mut *db)
    .await?;
    sqlx::query(
        "UPDATE streams SET sequence = ?, node_count = ?, input_sha256 = ?, version = ?, updated_at = ? WHERE seq = ?",
    )
    .bind(signed(block.sequence))
    .bind(signed(stream.node_count + posted))
    .bind(block.input_sha256.as_slice())
    .bind(signed(stream.version + 1))
    .bind(at.as_str())
    .bind(seq)
    .execute(&mut *db)
    .await?;
    if let Some(state) = &block.state {
        sqlx::query(
            "INSERT INTO stream_states (stream, sequence, data) VALUES (?, ?, ?)
             ON CONFLICT (stream) DO UPDATE SET sequence = excluded.sequence, data = excluded.data",
        )
        .bind(seq)
        .bind(signed(block.sequence))
        .bind(state.as_slice())
        .execute(&mut *db)
        .await?;
    }
    let stored = Stored { number: 0, version: stream.version + 1 };
    keep_answer(db, receipt.as_ref(), stored, block.created_at).await?;
    Ok(stored)
}

/// The iteration is inserted as any other; the blocks go, since the iteration holds the nodes.
pub async fn finish_stream(db: &mut SqliteConnection, finish: &IncomingFinish) -> Written<Stored> {
    let (stream, seq) = stream_row(db, finish.stream).await?;
    if let Some(iteration) = stream.iteration {
        return Err(RepositoryError::StreamFinished { iteration }.into());
    }
    if finish.sequence != stream.sequence {
        return Err(RepositoryError::UnexpectedBlock { expected: stream.sequence + 1 }.into());
    }
    let mut stored = bulk::insert_iterations(db, &[&finish.incoming]).await?;
    let stored = stored.pop().unwrap_or(Err(RepositoryError::NotFound(What::Job)))?;
    let iteration = &finish.incoming.iteration;
    sqlx::query(
        "UPDATE streams SET version = ?, updated_at = ?, iteration =
         (SELECT i.seq FROM iterations i WHERE i.job = streams.job AND i.number = ?) WHERE seq = ?",
    )
    .bind(signed(stream.version + 1))
    .bind(time::to_text(iteration.created_at))
    .bind(stored.number)
    .bind(seq)
    .execute(&mut *db)
    .await?;
    forget_blocks(db, seq).await?;
    Ok(stored)
}

pub async fn delete_stream(
    db: &mut SqliteConnection,
    id: Uuid,
    precondition: &Precondition,
    now: Timestamp,
) -> Written<()> {
    let (stream, seq) = stream_row(db, id).await?;
    precondition.check(stream.version)?;
    forget_blocks(db, seq).await?;
    // the event of the deletion carries this time
    sqlx::query("UPDATE streams SET updated_at = ? WHERE seq = ?")
        .bind(time::to_text(now))
        .bind(seq)
        .execute(&mut *db)
        .await?;
    sqlx::query("DELETE FROM streams WHERE seq = ?").bind(seq).execute(&mut *db).await?;
    Ok(())
}

async fn forget_blocks(db: &mut SqliteConnection, stream: i64) -> Written<()> {
    sqlx::query("DELETE FROM stream_states WHERE stream = ?").bind(stream).execute(&mut *db).await?;
    sqlx::query("DELETE FROM stream_blocks WHERE stream = ?").bind(stream).execute(&mut *db).await?;
    Ok(())
}

/// Refuses to delete a job with streams; takes the events of one without anything along.
pub async fn release_job(db: &mut SqliteConnection, job: i64) -> Written<()> {
    let row = sqlx::query("SELECT count(*) FROM streams WHERE job = ?").bind(job).fetch_one(&mut *db).await?;
    match rows::unsigned::<u64>(&row, 0)? {
        0 => {
            sqlx::query("DELETE FROM events WHERE job = ?").bind(job).execute(&mut *db).await?;
            Ok(())
        }
        count => Err(RepositoryError::HasStreams(count).into()),
    }
}

pub async fn stream(db: &SqlitePool, id: Uuid) -> Read<Stream> {
    let mut db = db.acquire().await.map_err(sql)?;
    let row = sqlx::query(concat!("SELECT ", stream_columns!(), " WHERE s.id = ?"))
        .bind(id)
        .fetch_optional(&mut *db)
        .await
        .map_err(sql)?;
    read_stream(&row.ok_or(RepositoryError::NotFound(What::Stream))?)
}

pub async fn stream_state(db: &SqlitePool, id: Uuid) -> Read<(Stream, Option<StreamState>, Option<[u8; 32]>)> {
    let mut db = db.begin().await.map_err(sql)?;
    let row = sqlx::query(concat!("SELECT ", stream_columns!(), " WHERE s.id = ?"))
        .bind(id)
        .fetch_optional(&mut *db)
        .await
        .map_err(sql)?
        .ok_or(RepositoryError::NotFound(What::Stream))?;
    let (stream, seq): (Stream, i64) = (read_stream(&row)?, get(&row, 11)?);
    let state = sqlx::query("SELECT sequence, data FROM stream_states WHERE stream = ?")
        .bind(seq)
        .fetch_optional(&mut *db)
        .await
        .map_err(sql)?;
    let state = match state {
        Some(row) => Some(StreamState { sequence: rows::unsigned(&row, 0)?, data: get(&row, 1)? }),
        None => None,
    };
    let last = sqlx::query("SELECT sha256 FROM stream_blocks WHERE stream = ? AND sequence = ?")
        .bind(seq)
        .bind(signed(stream.sequence))
        .fetch_optional(&mut *db)
        .await
        .map_err(sql)?;
    let last = last.map(|row| digest(&row, 0)).transpose()?;
    Ok((stream, state, last))
}

pub async fn blocks(db: &SqlitePool, id: Uuid, after: u64) -> Read<Vec<Block>> {
    let mut db = db.begin().await.map_err(sql)?;
    // the running total is that of the blocks before, so the first one always comes
    let rows = sqlx::query(
        "SELECT sequence, sha256, data FROM (
             SELECT b.sequence, b.sha256, b.data,
                    coalesce(sum(length(b.data)) OVER (ORDER BY b.sequence ROWS BETWEEN UNBOUNDED PRECEDING AND 1 \
                    PRECEDING), 0)
                    AS before
             FROM stream_blocks b JOIN streams s ON s.seq = b.stream
             WHERE s.id = ? AND b.sequence > ? AND b.sequence <= ?
         ) WHERE before < ? ORDER BY sequence",
    )
    .bind(id)
    .bind(signed(after))
    .bind(signed(after).saturating_add(BLOCKS_AT_A_TIME))
    .bind(BYTES_AT_A_TIME)
    .fetch_all(&mut *db)
    .await
    .map_err(sql)?;
    rows.iter()
        .map(|row| {
            let nodes =
                nodes_codec::decode(get::<&[u8]>(row, 2)?).map_err(|error| damaged("nodes", &error.to_string()))?;
            Ok(Block { sequence: rows::unsigned(row, 0)?, sha256: digest(row, 1)?, nodes })
        })
        .collect()
}

pub async fn block_sha256(db: &SqlitePool, id: Uuid, sequence: u64) -> Read<Option<[u8; 32]>> {
    let row = sqlx::query(
        "SELECT b.sha256 FROM stream_blocks b JOIN streams s ON s.seq = b.stream WHERE s.id = ? AND b.sequence = ?",
    )
    .bind(id)
    .bind(signed(sequence))
    .fetch_optional(db)
    .await
    .map_err(sql)?;
    row.map(|row| digest(&row, 0)).transpose()
}

pub async fn events(db: &SqlitePool, job: Uuid, after: u64, limit: u32) -> Read<Vec<JobEvent>> {
    let mut db = db.begin().await.map_err(sql)?;
    let rows = sqlx::query(
        "SELECT e.number, e.created_at, e.kind, i.number, i.id,
                coalesce(f.id, (SELECT id FROM fits WHERE iteration = e.iteration ORDER BY seq LIMIT 1)),
                c.position, c.reason, d.decision, d.reason, e.stream, e.state, e.sequence, e.node_count
         FROM jobs j JOIN events e ON e.job = j.seq
              LEFT JOIN iterations i ON i.seq = e.iteration
              LEFT JOIN fits f ON f.seq = e.fit
              LEFT JOIN fit_choices c ON e.kind = 'fit' AND c.iteration = e.iteration AND c.position = e.position
              LEFT JOIN decisions d ON e.kind = 'decision' AND d.iteration = e.iteration AND d.position = e.position
         WHERE j.id = ? AND e.number > ? ORDER BY e.number LIMIT ?",
    )
    .bind(job)
    .bind(signed(after))
    .bind(i64::from(limit))
    .fetch_all(&mut *db)
    .await
    .map_err(sql)?;
    rows.iter().map(read_event).collect()
}

fn read_event(row: &sqlx::sqlite::SqliteRow) -> Read<JobEvent> {
    let kind: String = get(row, 2)?;
    let what = match kind.as_str() {
        "iteration" => Happening::Iteration { number: get(row, 3)?, id: get(row, 4)?, fit_id: get(row, 5)? },
        "fit" => Happening::Fit {
            number: get(row, 3)?,
            fit_id: get(row, 5)?,
            chosen: get::<Option<i64>>(row, 6)?.is_some(),
            reason: get(row, 7)?,
        },
        "decision" => {
            Happening::Decision { number: get(row, 3)?, decision: rows::decision(row, 8)?, reason: get(row, 9)? }
        }
        "stream" => {
            let state: String = get(row, 11)?;
            Happening::Stream {
                id: get(row, 10)?,
                state: StreamEvent::named(&state).ok_or_else(|| damaged("an event", &state))?,
                sequence: rows::unsigned(row, 12)?,
                node_count: rows::unsigned(row, 13)?,
                iteration: get::<Option<u32>>(row, 3)?,
            }
        }
        other => return Err(damaged("an event", other)),
    };
    Ok(JobEvent { number: rows::unsigned(row, 0)?, created_at: rows::moment(row, 1)?, what })
}

pub async fn last_event(db: &SqlitePool, job: Uuid) -> Read<u64> {
    let row = sqlx::query(
        "SELECT coalesce((SELECT max(number) FROM events WHERE job = j.seq), 0) FROM jobs j WHERE j.id = ?",
    )
    .bind(job)
    .fetch_optional(db)
    .await
    .map_err(sql)?
    .ok_or(RepositoryError::NotFound(What::Job))?;
    rows::unsigned(&row, 0)
}
