//! The use cases of old jobs: archived, and purged of what only takes space or tells of people.

use std::{io::Write, sync::Arc};

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    archive::{self, Archived, Key},
    audit::{Chain, Verdict},
    callers::{Caller, actor},
    idempotency::Keyed,
    outcome::RepositoryError,
    purge::{NewPurge, Purge, Seen},
    repository::Turn,
    service::{JobService, Jobs},
};

impl Jobs {
    /// Writes the archive of a job.
    pub async fn archive<W: Write + Send + 'static>(&self, job: Uuid, to: W) -> Result<(W, Archived), RepositoryError> {
        self.repository.job(job).await?;
        // a few at a time: each has a thread and what it compresses by
        let _place = self.service.archiving.acquire().await;
        let key = Key { tenant: self.tenant().clone(), job };
        let written = archive::archive(self.service.holdings.clone(), key, to).await;
        written.map_err(archive::ArchiveError::told)?.ok_or(RepositoryError::ArchiveDiffers)
    }

    /// Takes the nodes, results, texts and names of a job away, if the archive that was named is
    /// that of the job as it is now, and its audit is intact.
    pub async fn purge(
        &self,
        job: Uuid,
        reason: String,
        archive_sha256: [u8; 32],
        keyed: Option<Keyed<NewPurge>>,
    ) -> Result<Arc<NewPurge>, RepositoryError> {
        // of one that is purged, before or meanwhile, the store says when and why
        let seen = match self.repository.job(job).await?.purged_at {
            None => self.seen_in(job, archive_sha256).await?,
            Some(_) => None,
        };
        let purge = Purge { at: self.now(), reason, archive_sha256 };
        let new = Arc::new(NewPurge { job, purge, seen });
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

    /// How far the job had come in that archive, if it is the one that it has now.
    async fn seen_in(&self, job: Uuid, archive_sha256: [u8; 32]) -> Result<Option<Seen>, RepositoryError> {
        let (_, Archived { sha256, seen, .. }) = self.archive(job, std::io::sink()).await?;
        if sha256 != archive_sha256 {
            return Ok(None);
        }
        // what was changed behind the store's back would never be found again
        match self.repository.verify_audit(Chain::Job(job)).await? {
            Verdict::Broken { number, .. } => Err(RepositoryError::AuditBroken(number)),
            Verdict::Intact { .. } => Ok(Some(seen)),
        }
    }
}

impl JobService {
    /// A turn to purge what is old; none where another process has it.
    pub async fn retention_turn(&self) -> Result<Option<Turn>, RepositoryError> {
        self.store.turn().await
    }

    /// Jobs without activity since a time and that are not purged.
    pub async fn untouched(&self, since: Timestamp, most: u32) -> Result<Vec<Key>, RepositoryError> {
        self.store.untouched(since, most).await
    }

    /// The jobs of a tenant, for who purges what is old.
    pub fn for_retention(self: &Arc<Self>, key: &Key) -> Jobs {
        self.of(&Caller { tenant: key.tenant.clone(), actor: actor::RETENTION.into(), origin: Default::default() })
    }
}
