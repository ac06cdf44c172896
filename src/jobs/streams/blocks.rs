//! The way of a block: in its turn, estimated, stored, answered.
//!
//! A stream's slot is held from looking at its number to having stored the block, so of two clients
//! that post the same block one counts. Another process may have taken it: the store compares the
//! number and the chain of digests once more, and what it refuses is decided anew by what it holds.
//! The estimate moves on only when the block is stored: if storing fails, what is in memory is
//! dropped and made again. A caller that leaves while its block is estimated takes the block along;
//! from the moment the store has it, storing and what follows (the slot is held as long) do not
//! depend on the caller.

use std::sync::Arc;

use flankfit_engine::estimation::Recursive;
use uuid::Uuid;

use super::{
    cache::{CachedStream, Slot},
    state_codec,
};
use crate::jobs::{service::to_completion, *};

/// Nodes between two times that an estimate is stored, at least.
const UNSAVED: u64 = 64;

/// How often a block is estimated anew because the store holds other blocks than were known.
const ATTEMPTS: u32 = 3;

/// A block with what becomes of the stream by it.
struct Estimated {
    block: PostedBlock,
    after: Stream,
    estimate: Recursive,
    /// The estimate as bytes, when it is time to store it.
    state: Option<Vec<u8>>,
    answer: Answer,
}

impl Jobs {
    /// Adds a block, or returns the response to a repeated one again.
    pub async fn add_block<H: StreamHost>(
        &self,
        host: &H,
        id: Uuid,
        block: PostedBlock,
        key: Option<KeyedRequest>,
    ) -> Result<Answer, H::Error> {
        let mut slot = self.slot(id).await.map_err(StreamError::from)?;
        let mut live = self.loaded(host, id, &mut slot).await?;
        if !expects(&live.stream, &block) {
            live = self.caught_up(host, id, &mut slot).await?;
        }
        let mut attempt = 1;
        while expects(&live.stream, &block) {
            let estimated = estimated(host, live, block.clone()).await?;
            let answer = estimated.answer.clone();
            match self.store_block(slot, estimated, key.clone()).await {
                Ok(()) => return Ok(answer),
                Err(RepositoryError::UnexpectedBlock { .. } | RepositoryError::StreamFinished { .. })
                    if attempt < ATTEMPTS =>
                {
                    attempt += 1;
                    slot = self.slot(id).await.map_err(StreamError::from)?;
                    live = self.caught_up(host, id, &mut slot).await?;
                }
                Err(error) => return Err(StreamError::from(error).into()),
            }
        }
        self.answered_again(host, live, &block).await
    }

    /// Stores the next block of the stream in the slot and puts the stream as it is after it into
    /// the slot. The slot is held until the store has answered, and is empty if it is not known
    /// whether the block is stored: then the stream is read again.
    async fn store_block(
        &self,
        mut slot: Slot,
        estimated: Estimated,
        key: Option<KeyedRequest>,
    ) -> Result<(), RepositoryError> {
        let Some(before) = slot.take() else {
            return Err(RepositoryError::Failed("a block came to a stream that is not in memory".into()));
        };
        let Estimated { block, after, estimate, state, answer } = estimated;
        let unsaved = if state.is_some() { 0 } else { before.unsaved + block.nodes.posted() as u64 };
        let block = Arc::new(NewBlock {
            stream: after.id,
            sequence: block.sequence,
            sha256: block.sha256,
            previous_sha256: before.stream.input_sha256,
            input_sha256: after.input_sha256,
            nodes: block.nodes.into(),
            state,
            created_at: self.now(),
        });
        let keyed = key.map(|key| key.answered_by(move |_: &NewBlock, _| answer.clone()));
        let receipt = keyed.map(|keyed| keyed.receipt(block.clone()));
        let (repository, service) = (self.repository.clone(), self.service.clone());
        let (id, job) = (self.owned(after.id), self.owned(after.job_id));
        to_completion(async move {
            let outcome = match repository.insert_block(block.clone(), receipt).await {
                Ok(stored) => {
                    *slot = Some(CachedStream {
                        stream: Stream { version: stored.version, updated_at: block.created_at, ..after },
                        last_sha256: Some(block.sha256),
                        estimate,
                        unsaved,
                    });
                    service.announce(&job);
                    Ok(())
                }
                Err(error @ (RepositoryError::Overloaded | RepositoryError::UnexpectedBlock { .. })) => {
                    *slot = Some(before);
                    Err(error)
                }
                Err(error) => Err(error),
            };
            service.cache.set_size(&id, slot.as_ref());
            outcome
        })
        .await
    }

    /// A block that is not the next one: the answer it had, or why it is refused.
    async fn answered_again<H: StreamHost>(
        &self,
        host: &H,
        live: &CachedStream,
        block: &PostedBlock,
    ) -> Result<Answer, H::Error> {
        let stream = &live.stream;
        stream.check_open().map_err(StreamError::from)?;
        // what is in memory may have been purged meanwhile
        self.repository.stream(stream.id).await.map_err(StreamError::from)?;
        let (sequence, expected) = (block.sequence, stream.expected());
        if sequence > expected {
            return Err(StreamError::BlockTooEarly { sequence, expected }.into());
        }
        let last = sequence == stream.sequence;
        let stored = if last {
            live.last_sha256
        } else {
            self.repository.block_sha256(stream.id, sequence).await.map_err(StreamError::from)?
        };
        if stored != Some(block.sha256) {
            return Err(StreamError::BlockChanged { sequence, expected }.into());
        }
        // as the stream was after that block
        let then = if last { live.clone() } else { self.earlier(host, stream, sequence).await? };
        host.compute(move || H::answer(&then.stream, &then.estimate)).await
    }
}

fn expects(stream: &Stream, block: &PostedBlock) -> bool {
    stream.iteration.is_none() && block.sequence == stream.expected()
}

/// Adds the block to a copy of the estimate: given up in here, the stream stays as it was.
async fn estimated<H: StreamHost>(host: &H, live: &CachedStream, block: PostedBlock) -> Result<Estimated, H::Error> {
    let after = live.stream.after(&block.sha256, block.nodes.posted());
    let unsaved = live.unsaved + block.nodes.posted() as u64;
    let mut estimate = live.estimate.clone();
    host.compute(move || {
        H::add_nodes(&mut estimate, &after.measurand, &block.nodes)?;
        let answer = H::answer(&after, &estimate)?;
        // as much is read again after a restart as an analysis costs anyway
        let due = unsaved >= UNSAVED.max(4 * estimate.size().unwrap_or(0) as u64);
        let state = if due { estimate.state().map(|state| state_codec::encode(&state)) } else { None };
        Ok(Estimated { block, after, estimate, state, answer })
    })
    .await
}
