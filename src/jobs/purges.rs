//! The use cases of old jobs: archived, and purged of what only takes space or names people.

use std::{io, sync::Arc};

use jiff::Timestamp;
use tokio::sync::OwnedSemaphorePermit;
use uuid::Uuid;

use super::{
    archive::{self, ArchiveError, Key},
    idempotency::Keyed,
    outcome::RepositoryError,
    service::Jobs,
};

/// The right to write an archive.
pub struct ArchivePlace(#[expect(dead_code, reason = "it is held")] OwnedSemaphorePermit);

impl Jobs {
    /// Returns a place for writing an archive, if there is one: each takes a connection.
    pub fn archiving(&self) -> Option<ArchivePlace> {
        self.service.archiving.clone().try_acquire_owned().ok().map(ArchivePlace)
    }

    /// Writes the archive of a job.
    pub async fn archive<F>(
        &self,
        _place: ArchivePlace,
        job: Uuid,
        mut write: impl FnMut(String) -> F,
    ) -> Result<(), ArchiveError>
    where
        F: Future<Output = io::Result<()>>,
    {
        let key = Key { tenant: self.tenant().clone(), job };
        archive::export(&*self.service.holdings, &key, &mut write).await?;
        write(archive::last_line(1)).await?;
        Ok(())
    }

    /// Removes the nodes, results, texts and names of a job.
    pub async fn purge(
        &self,
        job: Uuid,
        reason: String,
        keyed: Option<Keyed<Purge>>,
    ) -> Result<Arc<Purge>, RepositoryError> {
        let new = Arc::new(Purge { job, at: self.now(), reason });
        let receipt = keyed.map(|keyed| keyed.receipt(new.clone()));
        let (service, purging) = (self.service.clone(), self.repository.purge_job(new.clone(), receipt));
        let purged = self.change(job, async move {
            purging.await?;
            // its streams take nothing more
            service.announce_stream_end();
            Ok(())
        });
        purged.await?;
        Ok(new)
    }
}

/// A purge of a job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Purge {
    pub job: Uuid,
    pub at: Timestamp,
    pub reason: String,
}
