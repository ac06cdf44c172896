//! The use cases of jobs that are stored as a whole, and of what the store is rid of in time.

use std::{sync::Arc, time::Duration};

use uuid::Uuid;

use crate::jobs::*;

/// Rows forgotten in one transaction, so that no other write waits long.
const AT_A_TIME: u32 = 1000;

/// Between two such transactions, where there may be very many.
const BETWEEN: Duration = Duration::from_millis(10);

impl Jobs {
    /// Stores jobs with all their iterations, in one transaction; returns their ids. Without jobs
    /// only the answer to a keyed request is kept.
    pub async fn add_runs(
        &self,
        drafts: Vec<(JobDraft, Vec<IterationDraft>)>,
        keyed: Option<Keyed<Vec<Uuid>>>,
    ) -> Result<(Arc<Vec<Uuid>>, Stored), RepositoryError> {
        let now = self.now();
        let runs: Vec<NewRun> = drafts
            .into_iter()
            .map(|(job, iterations)| {
                let job = self.new_job(job);
                let iterations =
                    iterations.into_iter().map(|draft| Arc::new(self.new_iteration(job.id, draft))).collect();
                NewRun { job, iterations }
            })
            .collect();
        let ids: Arc<Vec<Uuid>> = Arc::new(runs.iter().map(|run| run.job.id).collect());
        let receipt = keyed.map(|keyed| keyed.receipt(ids.clone()));
        let stored = self.repository.insert_runs(runs, receipt, now).await?;
        ids.iter().for_each(|id| self.service.announce(&self.owned(*id)));
        Ok((ids, stored))
    }
}

impl JobService {
    /// Forgets responses kept under idempotency keys that are older than any client asks for.
    pub async fn forget_old_answers(&self) -> Result<(), RepositoryError> {
        let before = self.now() - ANSWERS_KEPT;
        while self.store.forget_answers(before, AT_A_TIME).await? == u64::from(AT_A_TIME) {}
        Ok(())
    }

    /// Forgets the common order of events that are older than any listener goes on from.
    pub async fn forget_old_events(&self) -> Result<(), RepositoryError> {
        let now = self.now();
        while self.store.forget_event_order(now, now - EVENTS_TOLD, AT_A_TIME).await? == u64::from(AT_A_TIME) {
            // others write meanwhile
            tokio::time::sleep(BETWEEN).await;
        }
        Ok(())
    }

    /// Does so now and then, for ever.
    pub async fn upkeep(&self, every: Duration) {
        loop {
            tokio::time::sleep(every).await;
            if let Err(error) = self.forget_old_answers().await {
                tracing::warn!(%error, "expired idempotency keys could not be deleted");
            }
            if let Err(error) = self.forget_old_events().await {
                tracing::warn!(%error, "old events could not be deleted");
            }
        }
    }
}
