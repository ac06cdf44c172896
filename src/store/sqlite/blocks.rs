//! Blocks of an open stream, and the estimate's numbers after some of them.

use sqlx::{SqliteConnection, SqlitePool};

use super::{answers, audit, locate::signed, streams, time};
use crate::{
    jobs::{Block, Caller, RepositoryError, Stored, Stream, StreamState, audit::Action},
    store::shared::{
        Asked, BlockRow, Digest, GetBlockSha256, GetBlocks, GetStreamState, InsertBlock, Outcome, Read, StateRow,
        Write, target,
    },
};

/// Bytes of blocks that are read at a time, beyond the first block.
const BYTES_AT_A_TIME: i64 = 8 << 20;
/// Blocks that are read at a time.
const BLOCKS_AT_A_TIME: i64 = 1024;

impl Read<SqlitePool> for GetStreamState {
    async fn read(
        &self,
        caller: &Caller,
        from: &SqlitePool,
    ) -> Outcome<(Stream, Option<StreamState>, Option<[u8; 32]>)> {
        let mut db = from.begin().await?;
        let (seq, stream) = streams::located(&mut db, &caller.tenant, self.id).await?;
        let state: Option<StateRow> = sqlx::query_as("SELECT sequence, data FROM stream_states WHERE stream = ?")
            .bind(seq)
            .fetch_optional(&mut *db)
            .await?;
        let last: Option<Digest> =
            sqlx::query_scalar("SELECT sha256 FROM stream_blocks WHERE stream = ? AND sequence = ?")
                .bind(seq)
                .bind(signed(stream.sequence))
                .fetch_optional(&mut *db)
                .await?;
        Ok((stream, state.map(Into::into), last.map(|digest| digest.0)))
    }
}

impl Read<SqlitePool> for GetBlocks {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Vec<Block>> {
        let mut db = from.begin().await?;
        // the running total is that of the blocks before, so the first one always comes
        let rows: Vec<BlockRow> = sqlx::query_as(
            "SELECT sequence, sha256, data FROM (
             SELECT b.sequence AS sequence, b.sha256 AS sha256, b.data AS data,
                    coalesce(sum(length(b.data)) OVER
                        (ORDER BY b.sequence ROWS BETWEEN UNBOUNDED PRECEDING AND 1 PRECEDING), 0) AS before
             FROM stream_blocks b JOIN streams s ON s.seq = b.stream JOIN jobs j ON j.seq = s.job
             WHERE s.id = ? AND j.tenant = ? AND b.sequence > ? AND b.sequence <= ?
         ) WHERE before < ? ORDER BY sequence",
        )
        .bind(self.id)
        .bind(caller.tenant.as_str())
        .bind(signed(self.after))
        .bind(signed(self.after).saturating_add(BLOCKS_AT_A_TIME))
        .bind(BYTES_AT_A_TIME)
        .fetch_all(&mut *db)
        .await?;
        Ok(rows.into_iter().map(Into::into).collect())
    }
}

impl Read<SqlitePool> for GetBlockSha256 {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Option<[u8; 32]>> {
        let digest: Option<Digest> = sqlx::query_scalar(
            "SELECT b.sha256 FROM stream_blocks b JOIN streams s ON s.seq = b.stream JOIN jobs j ON j.seq = s.job
         WHERE s.id = ? AND j.tenant = ? AND b.sequence = ?",
        )
        .bind(self.id)
        .bind(caller.tenant.as_str())
        .bind(signed(self.sequence))
        .fetch_optional(from)
        .await?;
        Ok(digest.map(|digest| digest.0))
    }
}

impl Write<SqliteConnection> for InsertBlock {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Stored> {
        let (InsertBlock { block, receipt }, tenant) = (&asked.write, asked.tenant());
        let (seq, stream) = streams::located(db, tenant, block.stream).await?;
        stream.check_open()?;
        let expected = stream.expected();
        if (block.sequence, block.previous_sha256) != (expected, stream.input_sha256) {
            return Err(RepositoryError::UnexpectedBlock { expected }.into());
        }
        answers::refuse_taken(db, tenant, receipt.as_ref()).await?;
        let mut chain = audit::of_job(db, asked.by(), stream.job_id).await?;
        let posted = block.nodes.posted() as u64;
        let at = time::to_text(block.created_at);
        sqlx::query(
            "INSERT INTO stream_blocks (stream, sequence, sha256, count, data, created_at) VALUES (?, ?, ?, ?, ?, ?)",
        )
        .bind(seq)
        .bind(signed(block.sequence))
        .bind(block.sha256.as_slice())
        .bind(signed(posted))
        .bind(block.nodes.bytes())
        .bind(at.as_str())
        .execute(&mut *db)
        .await?;
        sqlx::query(
            "UPDATE streams SET sequence = ?, node_count = ?, input_sha256 = ?, version = ?, updated_at = ?
             WHERE seq = ?",
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
        asked.enter(&mut chain, Action::AddBlock, target::block(block.stream, block.sequence));
        audit::store(db, chain).await?;
        let stored = Stored { number: 0, version: stream.version + 1 };
        answers::keep(db, tenant, receipt.as_ref(), stored, block.created_at, None).await?;
        Ok(stored)
    }
}
