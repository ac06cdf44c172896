//! Blocks of an open stream, and the estimate's numbers after some of them.

use super::{audit, prelude::*, streams, subject};

from_row! {
    Block { sequence, sha256, nodes = "data" }
    StreamState { sequence, data }
}

/// Bytes of blocks that are read at a time, in addition to the first block.
const BYTES_AT_A_TIME: i64 = 8 << 20;
/// Blocks that are read at a time.
const BLOCKS_AT_A_TIME: u64 = 1024;

pub async fn stream_state(
    db: &mut Db,
    caller: &Caller,
    id: &Uuid,
) -> Outcome<(Stream, Option<StreamState>, Option<[u8; 32]>)> {
    let stream = streams::located(db, &caller.tenant, *id).await?;
    let state = db.maybe("SELECT sequence, data FROM stream_states WHERE stream = $1", args![id]).await?;
    let last = "SELECT sha256 FROM stream_blocks WHERE stream = $1 AND sequence = $2";
    let last = db.first(last, args![id, stream.sequence]).await?;
    Ok((stream, state, last))
}

pub async fn blocks(db: &mut Db, caller: &Caller, id: &Uuid, after: &u64) -> Outcome<Vec<Block>> {
    // the running total is that of the blocks before, so the first one always comes
    let sql = "SELECT sequence, sha256, data FROM (
                   SELECT b.sequence AS sequence, b.sha256 AS sha256, b.data AS data,
                          coalesce(sum(length(b.data)) OVER
                              (ORDER BY b.sequence ROWS BETWEEN UNBOUNDED PRECEDING AND 1 PRECEDING), 0) AS before
                   FROM stream_blocks b JOIN streams s ON s.id = b.stream JOIN jobs j ON j.id = s.job
                   WHERE s.id = $1 AND j.tenant = $2 AND b.sequence > $3 AND b.sequence <= $4
               ) AS blocks WHERE before < $5 ORDER BY sequence";
    let last = after.saturating_add(BLOCKS_AT_A_TIME);
    Ok(db.all(sql, args![id, &caller.tenant, *after, last, BYTES_AT_A_TIME]).await?)
}

pub async fn block_sha256(db: &mut Db, caller: &Caller, id: &Uuid, sequence: &u64) -> Outcome<Option<[u8; 32]>> {
    let sql = "SELECT b.sha256 FROM stream_blocks b JOIN streams s ON s.id = b.stream JOIN jobs j ON j.id = s.job
               WHERE s.id = $1 AND j.tenant = $2 AND b.sequence = $3";
    Ok(db.first(sql, args![id, &caller.tenant, *sequence]).await?)
}

pub async fn insert_block(tx: &mut Tx<'_>, write: &InsertBlock) -> Outcome<Stored> {
    let (block, tenant) = (&write.block, tx.tenant());
    let stream = streams::located(tx.db(), tenant, block.stream).await?;
    stream.check_open()?;
    let expected = stream.expected();
    if (block.sequence, block.previous_sha256) != (expected, stream.input_sha256) {
        return Err(RepositoryError::UnexpectedBlock { expected }.into());
    }
    tx.refuse_taken()?;
    let mut entry = tx.draft(stream.job_id, Action::AddBlock, subject::block(block.stream, block.sequence))?;
    let (db, posted, version) = (tx.db(), block.nodes.posted() as u64, stream.version + 1);
    let row = args![block.stream, block.sequence, &block.sha256, posted, block.nodes.bytes(), block.created_at];
    let columns = "stream, sequence, sha256, count, data, created_at";
    audit::insert(db, "stream_blocks", columns, row.to_vec(), &mut entry).await?;
    db.run(
        "UPDATE streams SET sequence = $1, node_count = $2, input_sha256 = $3, version = $4, updated_at = $5
         WHERE id = $6",
        args![block.sequence, stream.node_count + posted, &block.input_sha256, version, block.created_at, block.stream],
    )
    .await?;
    if let Some(state) = &block.state {
        db.run(
            "INSERT INTO stream_states (stream, sequence, data) VALUES ($1, $2, $3)
             ON CONFLICT (stream) DO UPDATE SET sequence = excluded.sequence, data = excluded.data",
            args![block.stream, block.sequence, state],
        )
        .await?;
        entry.note("stream_states", "stream, sequence, data", args![block.stream, block.sequence, state]);
    }
    entry.note_stored(db, "streams", "id = $1", args![block.stream]).await?;
    entry.note_event(db, stream.job_id).await?;
    tx.enter(entry);
    Ok(tx.keep(&write.receipt, Stored { number: 0, version }, None, block.created_at))
}
