//! The use cases: they give ids and times, and say what is stored together.

use std::sync::Arc;

use jiff::Timestamp;
use tokio::{
    sync::{Semaphore, watch},
    task::JoinError,
};
use tracing::Instrument as _;
use uuid::Uuid;

use super::{
    archive::{Holdings, Key},
    audit::{self, Evidence, Sealed, Sealing, SigningKey, Verdict},
    known_jobs::KnownJobs,
    streams::StreamCache,
    summary::first_week,
};
use crate::jobs::*;

/// Archives that are written at a time, and verifications that go on.
const ARCHIVES: usize = 2;

/// Common state of the use cases of all callers.
pub struct JobService {
    pub(super) store: Arc<dyn Store>,
    /// The jobs as rows.
    pub(super) holdings: Arc<dyn Holdings>,
    pub(super) clock: Arc<dyn Clock>,
    ids: Arc<dyn Ids>,
    pub(super) known: KnownJobs,
    pub(super) cache: StreamCache,
    pub(super) notifier: JobNotifier,
    /// Told when some key was changed, here or by another process.
    pub(super) key_changes: watch::Sender<u64>,
    /// Archives that may be written at a time.
    pub(super) archiving: Arc<Semaphore>,
    /// Verifications that may go on at a time.
    verifying: Semaphore,
    /// How other processes are woken that use the store.
    pub(super) wakes: Option<Arc<dyn Wakes>>,
}

impl JobService {
    pub fn new(store: Arc<dyn Store>, clock: Arc<dyn Clock>, ids: Arc<dyn Ids>) -> Arc<Self> {
        let (known, cache, notifier) = Default::default();
        let wakes = store.wakes();
        let key_changes = watch::channel(0).0;
        let (archiving, verifying) = (Arc::new(Semaphore::new(ARCHIVES)), Semaphore::new(ARCHIVES));
        let holdings = store.holdings();
        Arc::new(JobService {
            store,
            holdings,
            clock,
            ids,
            known,
            cache,
            notifier,
            key_changes,
            archiving,
            verifying,
            wakes,
        })
    }

    /// The jobs of a caller's tenant.
    pub fn of(self: &Arc<Self>, caller: &Caller) -> Jobs {
        Jobs {
            repository: self.store.of(caller),
            tenant: caller.tenant.clone(),
            actor: caller.known_actor(),
            service: self.clone(),
        }
    }

    /// Whether other processes use the store, too.
    pub fn is_shared(&self) -> bool {
        self.wakes.is_some()
    }

    /// An id that nothing has yet.
    pub fn fresh_id(&self, now: Timestamp) -> Uuid {
        self.ids.fresh(now)
    }

    /// The time that whatever is written now carries.
    pub fn now(&self) -> Timestamp {
        self.clock.now()
    }

    /// Links and seals the entries that are not sealed; `None` if another process is doing so.
    pub async fn seal_audit(&self, key: Option<Arc<SigningKey>>) -> Result<Option<Sealed>, RepositoryError> {
        self.store.seal_audit(Sealing { at: self.now(), key }).await
    }

    /// Jobs without activity since a time that are not purged, after one of them.
    pub async fn untouched(
        &self,
        since: Timestamp,
        after: Option<Key>,
        most: u32,
    ) -> Result<Vec<Key>, RepositoryError> {
        self.store.untouched(since, after, most).await
    }

    /// Checks whether the store responds.
    pub async fn ping(&self) -> Result<(), RepositoryError> {
        self.store.ping().await
    }

    /// Whether anything can be written.
    pub async fn check_writable(&self) -> Result<(), RepositoryError> {
        self.store.check_writable(self.now()).await
    }
}

/// The jobs of one tenant and everything that a caller can do with them.
///
/// Whoever waits for a use case may leave at any time. What the store has taken is then finished
/// all the same, with what follows from it (`to_completion`); what it has not taken yet is not
/// begun.
#[derive(Clone)]
pub struct Jobs {
    /// Its reads are methods of [`Jobs`] too.
    pub(super) repository: Arc<dyn Repository>,
    pub(super) tenant: Tenant,
    /// Who the caller is, where that is known.
    actor: Option<Arc<str>>,
    pub(super) service: Arc<JobService>,
}

impl Jobs {
    /// To whom the jobs belong.
    pub fn tenant(&self) -> &Tenant {
        &self.tenant
    }

    /// A job or a stream of the tenant, as it is known in memory.
    pub(super) fn owned(&self, id: Uuid) -> Owned {
        Owned { tenant: self.tenant.clone(), id }
    }

    /// The time that whatever is written now carries.
    pub fn now(&self) -> Timestamp {
        self.service.now()
    }

    pub(super) fn fresh_id(&self, now: Timestamp) -> Uuid {
        self.service.fresh_id(now)
    }

    /// Returns the actor that is stored with changes of the caller.
    pub(super) fn actor(&self) -> Option<Arc<str>> {
        self.actor.clone()
    }

    /// Makes the event of a change by the caller at that time.
    pub(super) fn event(&self, reason: Option<String>, created_at: Timestamp) -> Event {
        Event { reason, by: self.actor(), created_at }
    }

    pub async fn create_job(&self, draft: JobDraft, keyed: Option<Keyed<Job>>) -> Result<Arc<Job>, RepositoryError> {
        let job = Arc::new(self.new_job(draft));
        let receipt = keyed.map(|keyed| keyed.receipt(job.clone()));
        let new = Job::clone(&job);
        self.write(job.id, self.repository.insert_job(new, receipt)).await?;
        Ok(job)
    }

    /// A job, before it is stored.
    pub(super) fn new_job(&self, draft: JobDraft) -> Job {
        let now = self.now();
        Job {
            id: self.fresh_id(now),
            name: draft.name,
            part_number: draft.part_number,
            serial_number: draft.serial_number,
            machine: draft.machine,
            gear: draft.gear,
            requirements: draft.requirements,
            tags: draft.tags,
            status: JobStatus::New,
            version: 1,
            created_at: now,
            updated_at: now,
            purged_at: None,
        }
    }

    /// Returns the numbers of jobs.
    pub async fn summary(&self) -> Result<JobSummary, RepositoryError> {
        Ok(self.repository.job_counts(first_week(self.now())).await?.summary())
    }

    pub async fn patch_job(
        &self,
        id: Uuid,
        patch: JobPatch,
        precondition: Precondition,
    ) -> Result<Job, RepositoryError> {
        self.change(id, self.repository.patch_job(id, patch, precondition, self.now())).await
    }

    /// Deletes a job that has no iterations.
    pub async fn delete_job(&self, id: Uuid, precondition: Precondition) -> Result<(), RepositoryError> {
        self.change(id, self.repository.delete_job(id, precondition)).await
    }

    /// Verifies the audit of a job, or of the whole tenant.
    pub async fn verify_audit(&self, job: Option<Uuid>) -> Result<Verdict, RepositoryError> {
        // a few at a time: each has a connection of its own
        let _place = self.service.verifying.acquire().await;
        let (auditor, evidence) = (self.service.store.auditor(), Evidence::default());
        let verdict = audit::examine(&*auditor, Some(&self.tenant), job, &evidence, &|_| {}).await?;
        match job {
            Some(_) if verdict.is_empty() && verdict.differences.is_empty() => {
                Err(RepositoryError::NotFound(Resource::Job))
            }
            _ => Ok(verdict),
        }
    }

    /// Is woken when something happens to any job of the tenant.
    pub fn listen_to_all(&self) -> watch::Receiver<u64> {
        self.service.notifier.subscribe_all(self.tenant.clone())
    }

    /// Is woken when something happens to the job.
    pub fn listen(&self, job: Uuid) -> watch::Receiver<u64> {
        self.service.notifier.subscribe(self.owned(job))
    }

    /// Returns the mapping that was kept last under a key. It is a proposal only: where the store
    /// fails there is none.
    pub async fn proposed_mapping(&self, key: [u8; 32]) -> Option<String> {
        self.repository.mapping(key).await.unwrap_or_else(|error| {
            tracing::warn!(%error, "the kept mapping of a table is not read");
            None
        })
    }

    /// Keeps a mapping. Where the store fails nothing is lost but a proposal: it is logged, and the
    /// request that has stored an iteration by it goes on.
    pub async fn keep_mapping(&self, kept: KeptMapping) {
        if self.proposed_mapping(kept.key).await.as_ref() == Some(&kept.mapping) {
            return;
        }
        if let Err(error) = self.repository.keep_mapping(kept, self.now()).await {
            tracing::warn!(%error, "the mapping of a table is not kept");
        }
    }

    /// Returns a job that a fit is computed for. Where this server alone changes jobs it may be one
    /// that was read before: its gear and requirements are current, its status and version need not
    /// be. (The write checks the job again.)
    pub async fn known_job(&self, id: Uuid) -> Result<Arc<Job>, RepositoryError> {
        let (known, owned) = (&self.service.known, self.owned(id));
        let changes = match known.get(&owned) {
            Ok(job) => return Ok(job),
            Err(changes) => changes,
        };
        let job = Arc::new(self.repository.job(id).await?);
        if !self.service.is_shared() {
            known.keep(owned, job.clone(), changes);
        }
        Ok(job)
    }

    /// Changes a job itself.
    pub(super) async fn change<T: Send + 'static>(
        &self,
        job: Uuid,
        changing: impl Future<Output = Result<T, RepositoryError>> + Send + 'static,
    ) -> Result<T, RepositoryError> {
        let (service, owned) = (self.service.clone(), self.owned(job));
        let changed = async move {
            let changed = changing.await;
            // also after an error: its outcome may be unknown
            service.known.forget(&owned);
            changed
        };
        self.write(job, changed).await
    }

    /// Stores something of a job and wakes who listens to it, even if the caller leaves meanwhile.
    pub(super) async fn write<T: Send + 'static>(
        &self,
        job: Uuid,
        writing: impl Future<Output = Result<T, RepositoryError>> + Send + 'static,
    ) -> Result<T, RepositoryError> {
        let (service, job) = (self.service.clone(), self.owned(job));
        let writing = async move {
            let written = writing.await?;
            service.announce(&job);
            Ok(written)
        };
        to_completion(writing).await
    }
}

/// Finishes what was begun even if its caller leaves. Nothing is begun before it is
/// awaited.
pub(super) async fn to_completion<T: Send + 'static>(rest: impl Future<Output = T> + Send + 'static) -> T {
    match tokio::spawn(rest.in_current_span()).await.map_err(JoinError::try_into_panic) {
        Ok(done) => done,
        Err(Ok(panic)) => std::panic::resume_unwind(panic),
        // the runtime stops, and its caller with it
        Err(Err(_stopped)) => std::future::pending().await,
    }
}
