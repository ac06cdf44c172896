//! The way of a block: in its turn, estimated, stored, answered. The same for requests and for
//! WebSockets.
//!
//! A stream's slot is held from looking at its number to having stored the block, so of two clients
//! that post the same block one counts; the store checks the number once more. The estimate moves
//! on only when the block is stored: if storing fails, what is in memory is dropped and made again
//! from what is stored. A client that leaves while its block is estimated takes the block along;
//! from the moment the store has it, storing and what follows (the slot is held as long) do not
//! depend on the client.

use std::{sync::Arc, time::Instant};

use uuid::Uuid;

use super::{conditional::etag, idempotency::Known, state::AppState};
use crate::{
    api::{
        fits::canonical,
        measurand::axes,
        problem::{Problem, ProblemCode},
        streams::{
            state,
            stream::{self, PostedBlock, Told},
        },
    },
    jobs::{Answer, BlockDraft, LiveStream, NewBlock, RepositoryError, Slot, Stream},
    telemetry,
};
use flankfit_engine::estimation::Recursive;

/// Nodes between two times that an estimate is written down, at least.
const UNWRITTEN: u64 = 64;

/// Adds a block, or answers a repeated one again.
pub async fn add_block(
    state: &AppState,
    id: Uuid,
    block: PostedBlock,
    known: Option<Known>,
) -> Result<Answer, Problem> {
    let begun = Instant::now();
    let mut slot = state.jobs.live().slot(id).await;
    let live = present(state, id, &mut slot).await?;
    if let Some(iteration) = live.stream.iteration {
        return Err(RepositoryError::StreamFinished { iteration }.into());
    }
    let expected = live.stream.sequence + 1;
    let answer = if block.sequence < expected {
        repeated(state, live, &block).await
    } else if block.sequence > expected {
        Err(Problem::new(
            ProblemCode::Conflict,
            format!(
                "Block {} came, but the stream expects block {expected} next: send the blocks in between first.",
                block.sequence
            ),
        ))
    } else {
        next(state, slot, block, known).await
    };
    metrics::histogram!(telemetry::BLOCK_SECONDS).record(begun.elapsed().as_secs_f64());
    answer
}

async fn next(state: &AppState, slot: Slot, block: PostedBlock, known: Option<Known>) -> Result<Answer, Problem> {
    let Some(live) = slot.as_ref() else { return Err(Problem::internal("a stream was loaded and is not there")) };
    let PostedBlock { sequence, nodes, sha256 } = block;
    let input_sha256 = canonical::after_block(&live.stream.input_sha256, &sha256);
    let node_count = live.stream.node_count + nodes.posted() as u64;
    let unwritten = live.unwritten + nodes.posted() as u64;
    let version = live.stream.version + 1;
    let mut estimate = live.estimate.clone();
    let pushed = nodes.clone();
    // Given up in here, the stream stays as it was.
    let of = live.stream.measurand.clone();
    let (estimate, written, body) = state
        .pool
        .run(move || {
            axes::check_block(&of, &pushed).map_err(Problem::invalid)?;
            estimate.push(&pushed).map_err(Problem::invalid)?;
            let told = stream::tell(&estimate, &input_sha256)?;
            // as much is read again after a restart as an analysis costs anyway
            let due = unwritten >= UNWRITTEN.max(4 * estimate.size().unwrap_or(0) as u64);
            let written = if due { estimate.state().map(|state| state::encode(&state)) } else { None };
            let body = stream::answer(sequence, node_count, &told);
            Ok::<_, Problem>((estimate, written, body))
        })
        .await??;
    let answered = body.clone();
    let keyed = known.map(|known| known.answered_by(move |_: &NewBlock, _| as_answer(answered.clone(), version)));
    let draft = BlockDraft { sequence, sha256, input_sha256, nodes, state: written };
    state.jobs.add_block(slot, draft, estimate, keyed).await?;
    Ok(as_answer(body, version))
}

fn as_answer(body: Vec<u8>, version: u64) -> Answer {
    Answer { status: 200, location: None, etag: Some(etag(version)), body }
}

/// A block that is stored already: the same answer again, or a conflict.
async fn repeated(state: &AppState, live: &LiveStream, block: &PostedBlock) -> Result<Answer, Problem> {
    let last = block.sequence == live.stream.sequence;
    let stored = if last { live.last_sha256 } else { state.jobs.block_sha256(live.stream.id, block.sequence).await? };
    if stored != Some(block.sha256) {
        return Err(Problem::new(
            ProblemCode::Conflict,
            format!(
                "Block {} was posted before with other nodes; the stream expects block {} next.",
                block.sequence,
                live.stream.sequence + 1
            ),
        ));
    }
    // as the stream was after that block
    let then = if last { live.clone() } else { replayed(state, &live.stream, block.sequence).await? };
    let body = state
        .pool
        .run(move || {
            let told = stream::tell(&then.estimate, &then.stream.input_sha256)?;
            Ok::<_, Problem>(stream::answer(then.stream.sequence, then.stream.node_count, &told))
        })
        .await??;
    Ok(as_answer(body, 1 + block.sequence))
}

/// The stream in its slot, made again from the store where it is not in memory.
pub async fn present<'a>(state: &AppState, id: Uuid, slot: &'a mut Slot) -> Result<&'a mut LiveStream, Problem> {
    if slot.is_none() {
        **slot = Some(load(state, id).await?);
        state.jobs.live().note(id, slot.as_ref());
    }
    slot.as_mut().ok_or_else(|| Problem::internal("a stream was loaded and is not there"))
}

async fn load(state: &AppState, id: Uuid) -> Result<LiveStream, Problem> {
    let (stream, written, last_sha256) = state.jobs.stream_state(id).await?;
    if stream.iteration.is_some() {
        let estimate = stream::empty_estimate(&stream)?;
        return Ok(LiveStream { stream, last_sha256, estimate, unwritten: 0 });
    }
    let restored = written.and_then(|written| {
        let estimate = stream::restored_estimate(&stream, &written.data)?;
        Some((estimate, written.sequence))
    });
    let (estimate, after) = match restored {
        Some(restored) => restored,
        None => (stream::empty_estimate(&stream)?, 0),
    };
    let begin = LiveStream { stream: stream.clone(), last_sha256, estimate, unwritten: 0 };
    let replayed = replay(state, begin, after, stream.sequence).await?;
    // numbers of the stream itself are those of the store: only the estimate was made again
    Ok(LiveStream { stream, ..replayed })
}

/// The stream as it was after an earlier block.
async fn replayed(state: &AppState, stream: &Stream, until: u64) -> Result<LiveStream, Problem> {
    let begin = Stream { sequence: 0, node_count: 0, input_sha256: stream::first_sha256(stream)?, ..stream.clone() };
    let estimate = stream::empty_estimate(stream)?;
    let begin = LiveStream { stream: begin, last_sha256: None, estimate, unwritten: 0 };
    replay(state, begin, 0, until).await
}

/// Adds the stored blocks after `after` up to `until`.
async fn replay(state: &AppState, mut live: LiveStream, mut after: u64, until: u64) -> Result<LiveStream, Problem> {
    while after < until {
        let blocks = state.jobs.blocks(live.stream.id, after).await?;
        let Some(last) = blocks.last().map(|block| block.sequence) else {
            return Err(Problem::internal(format!("block {} of stream {} is missing", after + 1, live.stream.id)));
        };
        let mut on = live;
        live = state
            .pool
            .run(move || {
                for block in blocks.iter().take_while(|block| block.sequence <= until) {
                    on.estimate.push(&block.nodes).map_err(|faults| {
                        Problem::internal(format!("stored block {} is refused: {:?}", block.sequence, faults.list()))
                    })?;
                    let posted = block.nodes.posted() as u64;
                    on.unwritten += posted;
                    on.stream.sequence = block.sequence;
                    on.stream.node_count += posted;
                    on.stream.input_sha256 = canonical::after_block(&on.stream.input_sha256, &block.sha256);
                }
                Ok::<_, Problem>(on)
            })
            .await??;
        after = last;
    }
    Ok(live)
}

/// The stream as it stands, with what its estimate tells.
pub async fn look(state: &AppState, id: Uuid) -> Result<(Stream, Option<Told>), Problem> {
    let stream = state.jobs.stream(id).await?;
    if stream.iteration.is_some() {
        return Ok((stream, None));
    }
    let mut slot = state.jobs.live().slot(id).await;
    let live = present(state, id, &mut slot).await?;
    let stream = live.stream.clone();
    if stream.iteration.is_some() {
        return Ok((stream, None));
    }
    let estimate: Recursive = live.estimate.clone();
    drop(slot);
    let input_sha256 = stream.input_sha256;
    let told = state.pool.run(move || stream::tell(&estimate, &input_sha256)).await??;
    Ok((stream, Some(told)))
}

/// Every node of a stream, in the order in which they came.
pub async fn all_nodes(state: &AppState, stream: &Stream) -> Result<Arc<flankfit_engine::estimation::Nodes>, Problem> {
    let (mut after, mut all) = (0, Vec::new());
    while after < stream.sequence {
        let blocks = state.jobs.blocks(stream.id, after).await?;
        let Some(last) = blocks.last().map(|block| block.sequence) else {
            return Err(Problem::internal(format!("block {} of stream {} is missing", after + 1, stream.id)));
        };
        after = last;
        all.extend(blocks.into_iter().map(|block| block.nodes));
    }
    let joined = state.pool.run(move || flankfit_engine::estimation::data::join(all)).await?;
    joined.map(Arc::new).ok_or_else(|| {
        Problem::new(ProblemCode::Conflict, "The stream has no nodes; there is nothing to make an iteration of.")
    })
}
