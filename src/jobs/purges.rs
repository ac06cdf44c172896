//! The use cases of old jobs: archived, and purged of what only takes space or names people.

use std::{io, sync::Arc};

use uuid::Uuid;

use super::{
    archive::{self, ArchiveError, Key},
    idempotency::Keyed,
    outcome::RepositoryError,
    purge::Purge,
    service::Jobs,
};

impl Jobs {
    /// Writes the archive of a job.
    pub async fn archive<F>(&self, job: Uuid, mut write: impl FnMut(String) -> F) -> Result<(), ArchiveError>
    where
        F: Future<Output = io::Result<()>>,
    {
        // a few at a time: each has a connection of its own
        let _place = self.service.archiving.acquire().await;
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
        let service = self.service.clone();
        let purged = self.write(job, |repository| async move {
            repository.purge_job(new.clone(), receipt).await?;
            // its streams take nothing more
            service.announce_stream_end();
            Ok(new)
        });
        let purged = purged.await?;
        self.service.known.remove(&self.owned(job));
        Ok(purged)
    }
}
