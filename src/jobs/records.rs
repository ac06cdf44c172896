//! The use cases of records: what is kept with an iteration beside its fits.

use std::sync::Arc;

use uuid::Uuid;

use super::{
    idempotency::Keyed,
    outcome::{RepositoryError, Stored},
    record::{Record, RecordDraft},
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
}
