//! Blocks of an open stream, and the estimate's numbers after some of them.

use sqlx::PgPool;

use super::{locate::signed, open::snapshot, session::Session, streams, time::stamp};
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

impl Read<PgPool> for GetStreamState {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<(Stream, Option<StreamState>, Option<[u8; 32]>)> {
        let mut db = snapshot(from).await?;
        let stream = streams::located(&mut db, &caller.tenant, self.id).await?;
        let state: Option<StateRow> = sqlx::query_as("SELECT sequence, data FROM stream_states WHERE stream = $1")
            .bind(self.id)
            .fetch_optional(&mut *db)
            .await?;
        let last: Option<Digest> =
            sqlx::query_scalar("SELECT sha256 FROM stream_blocks WHERE stream = $1 AND sequence = $2")
                .bind(self.id)
                .bind(signed(stream.sequence))
                .fetch_optional(&mut *db)
                .await?;
        Ok((stream, state.map(Into::into), last.map(|digest| digest.0)))
    }
}

impl Read<PgPool> for GetBlocks {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Vec<Block>> {
        // the running total is that of the blocks before, so the first one always comes
        let rows: Vec<BlockRow> = sqlx::query_as(
            "SELECT sequence, sha256, data FROM (
                 SELECT b.sequence, b.sha256, b.data,
                        coalesce(sum(octet_length(b.data)) OVER
                            (ORDER BY b.sequence ROWS BETWEEN UNBOUNDED PRECEDING AND 1 PRECEDING), 0) AS before
                 FROM stream_blocks b JOIN streams s ON s.id = b.stream JOIN jobs j ON j.id = s.job
                 WHERE s.id = $1 AND j.tenant = $2 AND b.sequence > $3 AND b.sequence <= $4
             ) AS blocks WHERE before < $5 ORDER BY sequence",
        )
        .bind(self.id)
        .bind(caller.tenant.as_str())
        .bind(signed(self.after))
        .bind(signed(self.after).saturating_add(BLOCKS_AT_A_TIME))
        .bind(BYTES_AT_A_TIME)
        .fetch_all(from)
        .await?;
        Ok(rows.into_iter().map(Into::into).collect())
    }
}

impl Read<PgPool> for GetBlockSha256 {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Option<[u8; 32]>> {
        let digest: Option<Digest> = sqlx::query_scalar(
            "SELECT b.sha256 FROM stream_blocks b JOIN streams s ON s.id = b.stream JOIN jobs j ON j.id = s.job
             WHERE s.id = $1 AND j.tenant = $2 AND b.sequence = $3",
        )
        .bind(self.id)
        .bind(caller.tenant.as_str())
        .bind(signed(self.sequence))
        .fetch_optional(from)
        .await?;
        Ok(digest.map(|digest| digest.0))
    }
}

impl Write<Session> for InsertBlock {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Stored> {
        let (InsertBlock { block, receipt }, tenant) = (&asked.write, asked.tenant());
        let stream = streams::located(&mut session.db, tenant, block.stream).await?;
        stream.check_open()?;
        let expected = stream.expected();
        if (block.sequence, block.previous_sha256) != (expected, stream.input_sha256) {
            return Err(RepositoryError::UnexpectedBlock { expected }.into());
        }
        session.keys.refuse_taken(tenant, receipt.as_ref())?;
        session.enter(asked, stream.job_id, Action::AddBlock, target::block(block.stream, block.sequence)).await?;
        let posted = block.nodes.posted() as u64;
        let db = &mut session.db;
        sqlx::query(
            "INSERT INTO stream_blocks (stream, sequence, sha256, count, data, created_at)
             VALUES ($1, $2, $3, $4, $5, $6)",
        )
        .bind(block.stream)
        .bind(signed(block.sequence))
        .bind(block.sha256.as_slice())
        .bind(signed(posted))
        .bind(block.nodes.bytes())
        .bind(stamp(block.created_at))
        .execute(&mut *db)
        .await?;
        sqlx::query(
            "UPDATE streams SET sequence = $1, node_count = $2, input_sha256 = $3, version = $4, updated_at = $5
             WHERE id = $6",
        )
        .bind(signed(block.sequence))
        .bind(signed(stream.node_count + posted))
        .bind(block.input_sha256.as_slice())
        .bind(signed(stream.version + 1))
        .bind(stamp(block.created_at))
        .bind(block.stream)
        .execute(&mut *db)
        .await?;
        if let Some(state) = &block.state {
            sqlx::query(
                "INSERT INTO stream_states (stream, sequence, data) VALUES ($1, $2, $3)
                 ON CONFLICT (stream) DO UPDATE SET sequence = excluded.sequence, data = excluded.data",
            )
            .bind(block.stream)
            .bind(signed(block.sequence))
            .bind(state.as_slice())
            .execute(db)
            .await?;
        }
        let stored = Stored { number: 0, version: stream.version + 1 };
        session.keys.keep(tenant, receipt.as_ref(), stored, block.created_at, None);
        Ok(stored)
    }
}
