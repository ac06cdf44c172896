//! Estimates made from what is stored: the numbers that were stored last, and the blocks since.

use flankfit_engine::estimation::{FitSpec, Nodes, Recursive};
use uuid::Uuid;

use super::{
    cache::{CachedStream, Slot},
    state_codec,
};
use crate::{jobs::*, telemetry};

impl Jobs {
    /// The stream in its slot, read from the store where it is not in memory. Other processes may
    /// have gone on since.
    pub(super) async fn loaded<'a, H: StreamHost>(
        &self,
        host: &H,
        id: Uuid,
        slot: &'a mut Slot,
    ) -> Result<&'a mut CachedStream, H::Error> {
        match &mut **slot {
            Some(live) => Ok(live),
            empty => {
                let live = self.load(host, id).await?;
                self.service.cache.set_size(&self.owned(id), Some(&live));
                Ok(empty.insert(live))
            }
        }
    }

    /// The stream in its slot, as the store has it now.
    pub(super) async fn caught_up<'a, H: StreamHost>(
        &self,
        host: &H,
        id: Uuid,
        slot: &'a mut Slot,
    ) -> Result<&'a mut CachedStream, H::Error> {
        if slot.is_some() {
            let stored = self.repository.stream(id).await.map_err(StreamError::from)?;
            if let Some(live) = slot.take() {
                if stored.sequence > live.stream.sequence {
                    telemetry::record_catch_up();
                }
                **slot = self.followed(host, live, stored).await?;
                self.service.cache.set_size(&self.owned(id), slot.as_ref());
            }
        }
        self.loaded(host, id, slot).await
    }

    /// Returns the stream in memory with the blocks that the store has after it; `None` if that
    /// leads to another stream than is stored.
    async fn followed<H: StreamHost>(
        &self,
        host: &H,
        live: CachedStream,
        stored: Stream,
    ) -> Result<Option<CachedStream>, H::Error> {
        let same = |live: &CachedStream| {
            (live.stream.sequence, live.stream.input_sha256) == (stored.sequence, stored.input_sha256)
        };
        if stored.iteration.is_some() {
            return Ok(None);
        }
        let live = self.with_blocks(host, live, stored.sequence).await?.filter(same);
        Ok(live.map(|live| CachedStream { stream: stored, ..live }))
    }

    async fn load<H: StreamHost>(&self, host: &H, id: Uuid) -> Result<CachedStream, H::Error> {
        // If blocks are gone the stream was finished or deleted meanwhile, and that is seen at the
        // second look.
        for _ in 0..2 {
            let (stream, state, last_sha256) = self.repository.stream_state(id).await.map_err(StreamError::from)?;
            let spec = H::read_spec(&stream.spec)?;
            let restored = state.filter(|_| stream.iteration.is_none()).and_then(|state| {
                let numbers = state_codec::decode(&state.data)?;
                Some((Recursive::restore(&spec, stream.forgetting_factor, &numbers)?, state.sequence))
            });
            let (estimate, sequence) = match restored {
                Some(restored) => restored,
                None => (before_any_node(&spec, &stream)?, 0),
            };
            if stream.iteration.is_some() {
                return Ok(CachedStream { stream, last_sha256, estimate, unsaved: 0 });
            }
            let begin = Stream { sequence, ..stream.clone() };
            let begin = CachedStream { stream: begin, last_sha256: None, estimate, unsaved: 0 };
            if let Some(live) = self.with_blocks(host, begin, stream.sequence).await? {
                // the stream itself is as the store has it: only the estimate was made again
                return Ok(CachedStream { stream, last_sha256, ..live });
            }
        }
        Err(StreamError::Damaged(format!("blocks of stream {id} are missing")).into())
    }

    /// The stream as it was after an earlier block.
    pub(super) async fn earlier<H: StreamHost>(
        &self,
        host: &H,
        stream: &Stream,
        sequence: u64,
    ) -> Result<CachedStream, H::Error> {
        let spec = H::read_spec(&stream.spec)?;
        let estimate = before_any_node(&spec, stream)?;
        let input_sha256 = H::first_sha256(&spec, stream.forgetting_factor);
        let begin = Stream { sequence: 0, node_count: 0, input_sha256, version: 1, ..stream.clone() };
        let begin = CachedStream { stream: begin, last_sha256: None, estimate, unsaved: 0 };
        let live = self.with_blocks(host, begin, sequence).await?;
        live.ok_or_else(|| StreamError::Damaged(format!("blocks of stream {} are missing", stream.id)).into())
    }

    /// Adds the stored blocks up to the one numbered `last`; `None` if one is missing.
    async fn with_blocks<H: StreamHost>(
        &self,
        host: &H,
        mut live: CachedStream,
        last: u64,
    ) -> Result<Option<CachedStream>, H::Error> {
        while live.stream.sequence < last {
            let blocks =
                self.repository.blocks(live.stream.id, live.stream.sequence).await.map_err(StreamError::from)?;
            if blocks.is_empty() {
                return Ok(None);
            }
            live = host
                .compute(move || {
                    for block in blocks.iter().take_while(|block| block.sequence <= last) {
                        live.estimate.push(&block.nodes).map_err(|faults| {
                            StreamError::Damaged(format!("block {} is refused: {:?}", block.sequence, faults.list()))
                        })?;
                        live.unsaved += block.nodes.posted() as u64;
                        live.stream = live.stream.after(&block.sha256, block.nodes.posted());
                        live.last_sha256 = Some(block.sha256);
                    }
                    Ok(live)
                })
                .await?;
        }
        Ok(Some(live))
    }

    /// Every node of a stream, in the order in which they came.
    pub(super) async fn all_nodes<H: StreamHost>(&self, host: &H, stream: &Stream) -> Result<Nodes, H::Error> {
        let (mut after, mut all) = (0, Vec::new());
        while after < stream.sequence {
            let blocks = self.repository.blocks(stream.id, after).await.map_err(StreamError::from)?;
            let Some(last) = blocks.last() else {
                // finished or deleted meanwhile, or
                self.repository.stream(stream.id).await.and_then(|now| now.check_open()).map_err(StreamError::from)?;
                return Err(StreamError::Damaged(format!("blocks of stream {} are missing", stream.id)).into());
            };
            after = last.sequence;
            all.extend(blocks.into_iter().map(|block| block.nodes));
        }
        let joined = host.compute(move || Ok(flankfit_engine::estimation::data::join(all))).await?;
        joined.ok_or_else(|| StreamError::NoNodes.into())
    }
}

fn before_any_node(spec: &FitSpec, stream: &Stream) -> Result<Recursive, StreamError> {
    Recursive::new(spec, stream.forgetting_factor)
        .map_err(|faults| StreamError::Damaged(format!("its spec is refused: {:?}", faults.list())))
}
