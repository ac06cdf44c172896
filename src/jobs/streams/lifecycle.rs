//! Streams from their opening to the iteration that they become.

use std::sync::Arc;

use flankfit_engine::estimation::{FitSpec, Nodes, Recursive};
use tokio::sync::watch;
use uuid::Uuid;

use super::cache::Slot;
use crate::jobs::*;

impl Jobs {
    /// Opens a stream.
    pub async fn open_stream(
        &self,
        job_id: Uuid,
        draft: StreamDraft,
        keyed: Option<Keyed<NewStream>>,
    ) -> Result<(Arc<NewStream>, Stored), RepositoryError> {
        let now = self.now();
        let stream = Arc::new(NewStream {
            id: self.fresh_id(now),
            job_id,
            spec: draft.spec,
            forgetting_factor: draft.forgetting_factor,
            input_sha256: draft.input_sha256,
            measurand: draft.measurand,
            created_at: now,
        });
        let receipt = keyed.map(|keyed| keyed.receipt(stream.clone()));
        let stored = self.write(job_id, self.repository.insert_stream(stream.clone(), receipt)).await?;
        Ok((stream, stored))
    }

    /// Some blocks of an open stream after the one numbered `after`, with the stream as it was
    /// before they were read.
    pub async fn stream_blocks(&self, id: Uuid, after: u64) -> Result<(Stream, Vec<Block>), RepositoryError> {
        let stream = self.repository.stream(id).await?;
        Ok((stream, self.repository.blocks(id, after).await?))
    }

    /// The stream, an open one with its estimate.
    pub async fn stream_with_estimate<H: StreamHost>(
        &self,
        host: &H,
        id: Uuid,
    ) -> Result<(Stream, Option<Recursive>), H::Error> {
        let stored = self.repository.stream(id).await.map_err(StreamError::from)?;
        if stored.iteration.is_some() {
            return Ok((stored, None));
        }
        let mut slot = self.slot(id).await.map_err(StreamError::from)?;
        let mut live = self.loaded(host, id, &mut slot).await?;
        if live.stream.version < stored.version {
            live = self.caught_up(host, id, &mut slot).await?;
        }
        let stream = live.stream.clone();
        let estimate = stream.iteration.is_none().then(|| live.estimate.clone());
        Ok((stream, estimate))
    }

    /// Makes a stream an iteration of its job: `fit` fits all of its nodes at once.
    pub async fn finish_stream<H: StreamHost>(
        &self,
        host: &H,
        id: Uuid,
        details: MeasurementDetails,
        fit: impl FnOnce(&Nodes, &FitSpec) -> Result<Computed, H::Error> + Send + 'static,
        keyed: Option<Keyed<NewIteration>>,
    ) -> Result<(Arc<NewIteration>, Stored), H::Error> {
        let mut slot = self.slot(id).await.map_err(StreamError::from)?;
        let stream = self.repository.stream(id).await.map_err(StreamError::from)?;
        stream.check_open().map_err(StreamError::from)?;
        let nodes = Arc::new(self.all_nodes(host, &stream).await?);
        let spec = H::read_spec(&stream.spec)?;
        let fitted = nodes.clone();
        let computed = host.compute(move || fit(&fitted, &spec)).await?;
        let draft = IterationDraft {
            nodes,
            computed,
            measurand: stream.measurand,
            details,
            records: Vec::new(),
            expected_gear: None,
        };
        let iteration = Arc::new(self.new_iteration(stream.job_id, draft));
        let receipt = keyed.map(|keyed| keyed.receipt(iteration.clone()));
        let finished = FinishedStream { stream: id, sequence: stream.sequence, iteration: iteration.clone() };
        let (service, repository) = (self.service.clone(), self.repository.clone());
        let stored = self.write(stream.job_id, async move {
            // stored or not: what is in memory is no longer sure
            *slot = None;
            let stored = repository.finish_stream(finished, receipt).await?;
            service.announce_stream_end();
            Ok((iteration, stored))
        });
        stored.await.map_err(|error| StreamError::from(error).into())
    }

    /// Deletes a stream with its blocks; an iteration that it has become stays.
    pub async fn delete_stream(&self, id: Uuid, precondition: Precondition) -> Result<(), RepositoryError> {
        let mut slot = self.slot(id).await?;
        let stream = self.repository.stream(id).await?;
        let (service, repository, now) = (self.service.clone(), self.repository.clone(), self.now());
        self.write(stream.job_id, async move {
            *slot = None;
            repository.delete_stream(id, precondition, now).await?;
            service.announce_stream_end();
            Ok(())
        })
        .await
    }

    /// Is woken when some stream has been finished or deleted.
    pub fn listen_for_stream_ends(&self) -> watch::Receiver<()> {
        self.service.cache.ends()
    }

    /// A stream's slot. Whether there is such a stream is asked before: for one of another tenant,
    /// or none at all, nothing is kept.
    pub(super) async fn slot(&self, id: Uuid) -> Result<Slot, RepositoryError> {
        let stream = self.owned(id);
        if !self.service.cache.knows(&stream) {
            self.repository.stream(id).await?;
        }
        Ok(self.service.cache.slot(stream).await)
    }
}
