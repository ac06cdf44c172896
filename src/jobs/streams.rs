//! The use cases of streams and of listening to a job.

use std::sync::Arc;

use tokio::sync::watch;
use uuid::Uuid;

use super::{
    draft::{BlockDraft, IterationDraft, StreamDraft},
    event::JobEvent,
    iteration::NewIteration,
    live::LiveStreams,
    repository::{Precondition, RepositoryError, Stored},
    service::{Jobs, Keyed},
    stream::{Block, FinishedStream, NewBlock, NewStream, Stream, StreamState},
};

impl Jobs {
    /// Opens a stream.
    pub async fn open_stream(
        &self,
        job_id: Uuid,
        draft: StreamDraft,
        keyed: Option<Keyed<NewStream>>,
    ) -> Result<(Arc<NewStream>, Stored), RepositoryError> {
        let now = self.clock.now();
        let stream = Arc::new(NewStream {
            id: self.ids.fresh(now),
            job_id,
            spec: draft.spec,
            forgetting_factor: draft.forgetting_factor,
            input_sha256: draft.input_sha256,
            created_at: now,
        });
        let receipt = keyed.map(|keyed| keyed.receipt(stream.clone()));
        let stored = self.repository.insert_stream(stream.clone(), receipt).await?;
        self.bells.ring(job_id);
        Ok((stream, stored))
    }

    pub async fn stream(&self, id: Uuid) -> Result<Stream, RepositoryError> {
        self.repository.stream(id).await
    }

    /// What an estimate is made again from.
    pub async fn stream_state(
        &self,
        id: Uuid,
    ) -> Result<(Stream, Option<StreamState>, Option<[u8; 32]>), RepositoryError> {
        self.repository.stream_state(id).await
    }

    /// Some blocks after the one numbered `after`, in order; empty at the end.
    pub async fn blocks(&self, id: Uuid, after: u64) -> Result<Vec<Block>, RepositoryError> {
        self.repository.blocks(id, after).await
    }

    /// Digest of one block.
    pub async fn block_sha256(&self, id: Uuid, sequence: u64) -> Result<Option<[u8; 32]>, RepositoryError> {
        self.repository.block_sha256(id, sequence).await
    }

    /// Stores the next block and answers the stream after it.
    pub async fn add_block(
        &self,
        stream: &Stream,
        draft: BlockDraft,
        keyed: Option<Keyed<NewBlock>>,
    ) -> Result<Stream, RepositoryError> {
        let now = self.clock.now();
        let block = Arc::new(NewBlock {
            stream: stream.id,
            sequence: draft.sequence,
            sha256: draft.sha256,
            input_sha256: draft.input_sha256,
            nodes: draft.nodes,
            state: draft.state,
            created_at: now,
        });
        let receipt = keyed.map(|keyed| keyed.receipt(block.clone()));
        let stored = self.repository.insert_block(block.clone(), receipt).await?;
        self.bells.ring(stream.job_id);
        Ok(Stream {
            sequence: block.sequence,
            node_count: stream.node_count + block.nodes.posted() as u64,
            input_sha256: block.input_sha256,
            version: stored.version,
            updated_at: now,
            ..stream.clone()
        })
    }

    /// Makes the stream an iteration of its job.
    pub async fn finish_stream(
        &self,
        stream: &Stream,
        draft: IterationDraft,
        keyed: Option<Keyed<NewIteration>>,
    ) -> Result<(Arc<NewIteration>, Stored), RepositoryError> {
        let iteration = Arc::new(self.new_iteration(stream.job_id, draft));
        let receipt = keyed.map(|keyed| keyed.receipt(iteration.clone()));
        let finished = FinishedStream { stream: stream.id, sequence: stream.sequence, iteration: iteration.clone() };
        let stored = self.repository.finish_stream(finished, receipt).await?;
        self.live.announce_end();
        self.bells.ring(stream.job_id);
        Ok((iteration, stored))
    }

    /// Deletes a stream with its blocks; an iteration that it has become stays.
    pub async fn delete_stream(&self, stream: &Stream, precondition: Precondition) -> Result<(), RepositoryError> {
        self.repository.delete_stream(stream.id, precondition, self.clock.now()).await?;
        self.live.announce_end();
        self.bells.ring(stream.job_id);
        Ok(())
    }

    /// Estimates of open streams.
    pub fn live(&self) -> &LiveStreams {
        &self.live
    }

    /// Some events of a job after the one numbered `after`, in order.
    pub async fn events(&self, job: Uuid, after: u64, limit: u32) -> Result<Vec<JobEvent>, RepositoryError> {
        self.repository.events(job, after, limit).await
    }

    /// The number of a job's last event.
    pub async fn last_event(&self, job: Uuid) -> Result<u64, RepositoryError> {
        self.repository.last_event(job).await
    }

    /// Is woken when something happens to the job.
    pub fn listen(&self, job: Uuid) -> watch::Receiver<()> {
        self.bells.listen(job)
    }
}
