//! The use cases of streams and of listening to a job.

use std::sync::Arc;

use tokio::sync::watch;
use uuid::Uuid;

use super::{
    draft::{BlockDraft, IterationDraft, StreamDraft},
    event::JobEvent,
    iteration::NewIteration,
    live::{LiveStreams, Slot},
    outcome::{Precondition, RepositoryError, Stored},
    service::{Jobs, Keyed, to_the_end},
    stream::{Block, FinishedStream, NewBlock, NewStream, Stream, StreamState},
};
use flankfit_engine::estimation::Recursive;

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
            measurand: draft.measurand,
            created_at: now,
        });
        let receipt = keyed.map(|keyed| keyed.receipt(stream.clone()));
        let (repository, notifier) = (self.repository.clone(), self.notifier.clone());
        to_the_end(async move {
            let stored = repository.insert_stream(stream.clone(), receipt).await?;
            notifier.notify(job_id);
            Ok((stream, stored))
        })
        .await
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

    /// Stores the next block of the stream in the slot and puts the stream as it is after it into
    /// the slot. The slot is held until the store has answered, and is empty if it cannot be told
    /// whether the block is stored: then the stream is read again.
    pub async fn add_block(
        &self,
        mut slot: Slot,
        draft: BlockDraft,
        estimate: Recursive,
        keyed: Option<Keyed<NewBlock>>,
    ) -> Result<(), RepositoryError> {
        let Some(before) = slot.take() else {
            return Err(RepositoryError::Failed("a block came to a stream that is not in memory".into()));
        };
        let now = self.clock.now();
        let block = Arc::new(NewBlock {
            stream: before.stream.id,
            sequence: draft.sequence,
            sha256: draft.sha256,
            input_sha256: draft.input_sha256,
            nodes: draft.nodes,
            state: draft.state,
            created_at: now,
        });
        let receipt = keyed.map(|keyed| keyed.receipt(block.clone()));
        let (repository, notifier, live) = (self.repository.clone(), self.notifier.clone(), self.live.clone());
        to_the_end(async move {
            let (id, job) = (before.stream.id, before.stream.job_id);
            let outcome = match repository.insert_block(block.clone(), receipt).await {
                Ok(stored) => {
                    *slot = Some(before.after(&block, stored, estimate));
                    notifier.notify(job);
                    Ok(())
                }
                Err(RepositoryError::Overloaded) => {
                    *slot = Some(before);
                    Err(RepositoryError::Overloaded)
                }
                Err(error) => Err(error),
            };
            live.note(id, slot.as_ref());
            outcome
        })
        .await
    }

    /// Makes the stream in the slot an iteration of its job. Afterwards the slot is empty.
    pub async fn finish_stream(
        &self,
        mut slot: Slot,
        stream: &Stream,
        draft: IterationDraft,
        keyed: Option<Keyed<NewIteration>>,
    ) -> Result<(Arc<NewIteration>, Stored), RepositoryError> {
        let iteration = Arc::new(self.new_iteration(stream.job_id, draft));
        let receipt = keyed.map(|keyed| keyed.receipt(iteration.clone()));
        let finished = FinishedStream { stream: stream.id, sequence: stream.sequence, iteration: iteration.clone() };
        let (repository, notifier, live) = (self.repository.clone(), self.notifier.clone(), self.live.clone());
        let job = stream.job_id;
        to_the_end(async move {
            // stored or not: what is in memory is no longer sure
            *slot = None;
            let stored = repository.finish_stream(finished, receipt).await?;
            live.announce_end();
            notifier.notify(job);
            Ok((iteration, stored))
        })
        .await
    }

    /// Deletes the stream in the slot with its blocks; an iteration that it has become stays.
    /// Afterwards the slot is empty.
    pub async fn delete_stream(
        &self,
        mut slot: Slot,
        stream: &Stream,
        precondition: Precondition,
    ) -> Result<(), RepositoryError> {
        let (repository, notifier, live) = (self.repository.clone(), self.notifier.clone(), self.live.clone());
        let (id, job, now) = (stream.id, stream.job_id, self.clock.now());
        to_the_end(async move {
            *slot = None;
            repository.delete_stream(id, precondition, now).await?;
            live.announce_end();
            notifier.notify(job);
            Ok(())
        })
        .await
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
        self.notifier.subscribe(job)
    }
}
