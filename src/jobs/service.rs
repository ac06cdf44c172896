//! The use cases: they give ids and times, and say what is stored together.

use std::sync::Arc;

use jiff::Timestamp;
use tokio::sync::watch;
use uuid::Uuid;

use super::{
    ambient::{Clock, Ids},
    draft::JobDraft,
    event::{JobEvent, JobNotifier},
    idempotency::Keyed,
    iteration::Trace,
    job::{Job, JobPatch},
    known_jobs::KnownJobs,
    outcome::{Precondition, RepositoryError},
    page::{Page, PageRequest},
    repository::Repository,
    streams::StreamCache,
};

/// Jobs and everything that can be done with them.
///
/// Whoever waits for a use case may leave at any time. What the store has taken is then finished
/// all the same, with what follows from it (`run_to_completion`); what it has not taken yet is not
/// begun.
pub struct Jobs {
    pub(super) repository: Arc<dyn Repository>,
    pub(super) clock: Arc<dyn Clock>,
    pub(super) ids: Arc<dyn Ids>,
    known: KnownJobs,
    pub(super) cache: Arc<StreamCache>,
    pub(super) notifier: Arc<JobNotifier>,
}

impl Jobs {
    pub fn new(repository: Arc<dyn Repository>, clock: Arc<dyn Clock>, ids: Arc<dyn Ids>) -> Self {
        Jobs { repository, clock, ids, known: KnownJobs::default(), cache: Arc::default(), notifier: Arc::default() }
    }

    /// The store beneath, for what is not about jobs (readiness, kept answers).
    pub fn repository(&self) -> &Arc<dyn Repository> {
        &self.repository
    }

    /// The time that whatever is written now carries.
    pub fn now(&self) -> Timestamp {
        self.clock.now()
    }

    pub async fn create_job(&self, draft: JobDraft, keyed: Option<Keyed<Job>>) -> Result<Arc<Job>, RepositoryError> {
        let job = Arc::new(self.new_job(draft));
        let receipt = keyed.map(|keyed| keyed.receipt(job.clone()));
        self.repository.insert_job(Job::clone(&job), receipt).await?;
        self.known.add(job.id);
        Ok(job)
    }

    /// A job, before it is stored.
    pub(super) fn new_job(&self, draft: JobDraft) -> Job {
        let now = self.clock.now();
        Job {
            id: self.ids.fresh(now),
            name: draft.name,
            part_number: draft.part_number,
            serial_number: draft.serial_number,
            machine: draft.machine,
            gear: draft.gear,
            tags: draft.tags,
            version: 1,
            created_at: now,
            updated_at: now,
        }
    }

    /// Whether anything can be written.
    pub async fn check_writable(&self) -> Result<(), RepositoryError> {
        self.repository.check_writable(self.clock.now()).await
    }

    /// Newest first.
    pub async fn list_jobs(&self, page: PageRequest) -> Result<Page<Job>, RepositoryError> {
        self.repository.jobs(page).await
    }

    pub async fn job(&self, id: Uuid) -> Result<Job, RepositoryError> {
        self.repository.job(id).await
    }

    pub async fn patch_job(
        &self,
        id: Uuid,
        patch: JobPatch,
        precondition: Precondition,
    ) -> Result<Job, RepositoryError> {
        self.repository.patch_job(id, patch, precondition, self.clock.now()).await
    }

    /// Deletes a job that has no iterations.
    pub async fn delete_job(&self, id: Uuid, precondition: Precondition) -> Result<(), RepositoryError> {
        self.repository.delete_job(id, precondition).await?;
        self.known.remove(id);
        Ok(())
    }

    /// A page of the story of a job.
    pub async fn trace(&self, job: Uuid, page: PageRequest) -> Result<Trace, RepositoryError> {
        self.repository.trace(job, page).await
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

    /// Refuses a job that does not exist before a fit is computed for it. (The write looks again.)
    pub async fn check_exists(&self, job: Uuid) -> Result<(), RepositoryError> {
        if !self.known.contains(job) {
            self.repository.job(job).await?;
            self.known.add(job);
        }
        Ok(())
    }

    /// Stores something of a job and wakes who listens to it, even if the caller leaves meanwhile.
    pub(super) async fn write<T, F>(
        &self,
        job: Uuid,
        write: impl FnOnce(Arc<dyn Repository>) -> F,
    ) -> Result<T, RepositoryError>
    where
        T: Send + 'static,
        F: Future<Output = Result<T, RepositoryError>> + Send + 'static,
    {
        let (writing, notifier) = (write(self.repository.clone()), self.notifier.clone());
        run_to_completion(async move {
            let written = writing.await?;
            notifier.notify(job);
            Ok(written)
        })
        .await
    }
}

/// Stores, and does what follows from it, even if the one who waits leaves meanwhile.
pub(super) async fn run_to_completion<T: Send + 'static>(
    storing: impl Future<Output = Result<T, RepositoryError>> + Send + 'static,
) -> Result<T, RepositoryError> {
    tokio::spawn(storing).await.unwrap_or_else(|lost| Err(RepositoryError::Failed(lost.to_string())))
}
