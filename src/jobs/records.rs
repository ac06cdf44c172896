//! The use cases of records: what is kept with an iteration beside its fits.

use std::sync::Arc;

use uuid::Uuid;

use super::{
    idempotency::Keyed,
    outcome::{RepositoryError, Stored},
    page::{Page, PageRequest},
    record::{Record, RecordDraft, RecordKind, RecordSummary},
    service::Jobs,
};

impl Jobs {
    /// Keeps a record with an iteration, beside those it has.
    pub async fn add_record(
        &self,
        job: Uuid,
        number: u32,
        draft: RecordDraft,
        keyed: Option<Keyed<Record>>,
    ) -> Result<(Arc<Record>, Stored), RepositoryError> {
        let now = self.now();
        let record = Arc::new(Record { id: self.fresh_id(now), created_at: now, by: self.actor(), draft });
        let receipt = keyed.map(|keyed| keyed.receipt(record.clone()));
        let kept = record.clone();
        let stored = self
            .write(job, |repository| async move { repository.insert_record(job, number, kept, receipt).await })
            .await?;
        Ok((record, stored))
    }

    pub async fn record(&self, job: Uuid, number: u32, id: Uuid) -> Result<Record, RepositoryError> {
        self.repository.record(job, number, id).await
    }

    /// The one of a kind that was kept last.
    pub async fn latest_record(
        &self,
        job: Uuid,
        number: u32,
        kind: RecordKind,
    ) -> Result<Option<Record>, RepositoryError> {
        self.repository.latest_record(job, number, kind).await
    }

    /// Oldest first.
    pub async fn records(
        &self,
        job: Uuid,
        number: u32,
        page: PageRequest,
    ) -> Result<Page<RecordSummary>, RepositoryError> {
        self.repository.records(job, number, page).await
    }
}
