//! The use cases: they give ids and times, and say what is stored together.

use std::{
    collections::HashSet,
    sync::{Arc, Mutex, PoisonError},
};

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    ambient::{Clock, Ids},
    draft::{IterationDraft, JobDraft, RefitDraft},
    event::JobNotifier,
    fit::{FitRecord, NewFit},
    idempotency::{Answer, KeyClaim, Receipt},
    iteration::{Choice, Decision, Event, FitSummary, Iteration, NewIteration, Ruling, Trace},
    job::{Job, JobPatch},
    live::LiveStreams,
    measurand::{Measurand, Successors},
    outcome::{Precondition, RepositoryError, Stored},
    page::{Page, PageRequest},
    record::Record,
    repository::Repository,
};
use flankfit_engine::estimation::Nodes;

/// Writes the answer to what was stored.
pub type AnswerWriter<T> = Box<dyn Fn(&T, Stored) -> Answer + Send + Sync>;

/// A keyed request, before what it stores has ids: the receipt's answer is written from `T`.
pub struct Keyed<T> {
    pub key: String,
    pub scope: String,
    pub request_sha256: [u8; 32],
    pub answer: AnswerWriter<T>,
    /// Held until the write has ended.
    pub claim: Option<KeyClaim>,
}

impl<T: Send + Sync + 'static> Keyed<T> {
    pub(super) fn receipt(self, of: Arc<T>) -> Receipt {
        let Keyed { key, scope, request_sha256, answer, claim } = self;
        Receipt { key, scope, request_sha256, answer: Box::new(move |stored| answer(&of, stored)), claim }
    }
}

/// Jobs and everything that can be done with them.
///
/// Whoever waits for a use case may leave at any time. What the store has taken is then finished
/// all the same, with what follows from it (`to_the_end`); what it has not taken yet is not begun.
pub struct Jobs {
    pub(super) repository: Arc<dyn Repository>,
    pub(super) clock: Arc<dyn Clock>,
    pub(super) ids: Arc<dyn Ids>,
    known: KnownJobs,
    pub(super) live: Arc<LiveStreams>,
    pub(super) notifier: Arc<JobNotifier>,
}

impl Jobs {
    pub fn new(repository: Arc<dyn Repository>, clock: Arc<dyn Clock>, ids: Arc<dyn Ids>) -> Self {
        Jobs { repository, clock, ids, known: KnownJobs::default(), live: Arc::default(), notifier: Arc::default() }
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

    /// Stores nodes with their first fit, which stands until somebody chooses another.
    pub async fn add_iteration(
        &self,
        job_id: Uuid,
        draft: IterationDraft,
        keyed: Option<Keyed<NewIteration>>,
    ) -> Result<(Arc<NewIteration>, Stored), RepositoryError> {
        let iteration = Arc::new(self.new_iteration(job_id, draft));
        let receipt = keyed.map(|keyed| keyed.receipt(iteration.clone()));
        let (repository, notifier) = (self.repository.clone(), self.notifier.clone());
        to_the_end(async move {
            let stored = repository.insert_iteration(iteration.clone(), receipt).await?;
            notifier.notify(job_id);
            Ok((iteration, stored))
        })
        .await
    }

    /// An iteration with its first fit, before it is stored.
    pub(super) fn new_iteration(&self, job_id: Uuid, draft: IterationDraft) -> NewIteration {
        let now = self.clock.now();
        NewIteration {
            id: self.ids.fresh(now),
            job_id,
            measurand: draft.measurand,
            measured_at: draft.measured_at,
            instrument: draft.instrument,
            operator: draft.operator,
            note: draft.note,
            created_at: now,
            nodes: draft.nodes,
            fit: NewFit { id: self.ids.fresh(now), computed: draft.computed, reason: None, created_at: now },
            records: draft
                .records
                .into_iter()
                .map(|draft| Record { id: self.ids.fresh(now), created_at: now, draft })
                .collect(),
            expected_gear: draft.expected_gear,
        }
    }

    pub async fn iteration(&self, job: Uuid, number: u32) -> Result<Iteration, RepositoryError> {
        self.repository.iteration(job, number).await
    }

    pub async fn nodes(&self, job: Uuid, number: u32) -> Result<Nodes, RepositoryError> {
        self.repository.nodes(job, number).await
    }

    /// What the nodes of an iteration are of.
    pub async fn measurand(&self, job: Uuid, number: u32) -> Result<Measurand, RepositoryError> {
        self.repository.measurand(job, number).await
    }

    /// What was measured after an iteration.
    pub async fn successors(&self, job: Uuid, number: u32) -> Result<Successors, RepositoryError> {
        self.repository.successors(job, number).await
    }

    /// The nodes of an iteration if they take at most so many bytes in the store, else how many
    /// they take.
    pub async fn nodes_up_to(
        &self,
        job: Uuid,
        number: u32,
        most: usize,
    ) -> Result<Result<Nodes, usize>, RepositoryError> {
        self.repository.nodes_up_to(job, number, most).await
    }

    /// Stores another fit of stored nodes. It does not stand until it is chosen.
    pub async fn add_fit(
        &self,
        job: Uuid,
        number: u32,
        draft: RefitDraft,
        keyed: Option<Keyed<NewFit>>,
    ) -> Result<(Arc<NewFit>, Stored), RepositoryError> {
        let now = self.clock.now();
        let fit = Arc::new(NewFit {
            id: self.ids.fresh(now),
            computed: draft.computed,
            reason: draft.reason,
            created_at: now,
        });
        let receipt = keyed.map(|keyed| keyed.receipt(fit.clone()));
        let (repository, notifier) = (self.repository.clone(), self.notifier.clone());
        to_the_end(async move {
            let stored = repository.insert_fit(job, number, fit.clone(), receipt).await?;
            notifier.notify(job);
            Ok((fit, stored))
        })
        .await
    }

    /// From now on this fit of the iteration stands.
    pub async fn choose_fit(
        &self,
        job: Uuid,
        number: u32,
        fit_id: Uuid,
        reason: Option<String>,
        precondition: Precondition,
    ) -> Result<Iteration, RepositoryError> {
        let choice = Choice { fit_id, event: Event { reason, created_at: self.clock.now() } };
        let (repository, notifier) = (self.repository.clone(), self.notifier.clone());
        to_the_end(async move {
            repository.choose(job, number, choice, precondition).await?;
            notifier.notify(job);
            Ok(())
        })
        .await?;
        self.iteration(job, number).await
    }

    /// What is done with the gear after this iteration.
    pub async fn decide(
        &self,
        job: Uuid,
        number: u32,
        decision: Decision,
        reason: Option<String>,
        precondition: Precondition,
    ) -> Result<Iteration, RepositoryError> {
        let ruling = Ruling { decision, event: Event { reason, created_at: self.clock.now() } };
        let (repository, notifier) = (self.repository.clone(), self.notifier.clone());
        to_the_end(async move {
            repository.rule(job, number, ruling, precondition).await?;
            notifier.notify(job);
            Ok(())
        })
        .await?;
        self.iteration(job, number).await
    }

    /// A stored fit in full.
    pub async fn fit(&self, job: Uuid, number: u32, fit: Uuid) -> Result<FitRecord, RepositoryError> {
        self.repository.fit(job, number, fit).await
    }

    /// Fits of an iteration in the order in which they were made.
    pub async fn fits(&self, job: Uuid, number: u32, page: PageRequest) -> Result<Page<FitSummary>, RepositoryError> {
        self.repository.fits(job, number, page).await
    }

    /// A page of the story of a job.
    pub async fn trace(&self, job: Uuid, page: PageRequest) -> Result<Trace, RepositoryError> {
        self.repository.trace(job, page).await
    }

    /// Refuses a job that does not exist before a fit is computed for it. (The write looks again.)
    pub async fn admit(&self, job: Uuid) -> Result<(), RepositoryError> {
        if !self.known.contains(job) {
            self.repository.job(job).await?;
            self.known.add(job);
        }
        Ok(())
    }
}

/// Stores, and does what follows from it, even if the one who waits leaves meanwhile.
pub(super) async fn to_the_end<T: Send + 'static>(
    storing: impl Future<Output = Result<T, RepositoryError>> + Send + 'static,
) -> Result<T, RepositoryError> {
    tokio::spawn(storing).await.unwrap_or_else(|lost| Err(RepositoryError::Failed(lost.to_string())))
}

/// Jobs lately seen to exist.
#[derive(Default)]
struct KnownJobs {
    ids: Mutex<HashSet<Uuid>>,
}

impl KnownJobs {
    const MOST: usize = 4096;

    fn contains(&self, id: Uuid) -> bool {
        self.ids.lock().unwrap_or_else(PoisonError::into_inner).contains(&id)
    }

    fn add(&self, id: Uuid) {
        let mut ids = self.ids.lock().unwrap_or_else(PoisonError::into_inner);
        if ids.len() >= Self::MOST {
            ids.clear();
        }
        ids.insert(id);
    }

    fn remove(&self, id: Uuid) {
        self.ids.lock().unwrap_or_else(PoisonError::into_inner).remove(&id);
    }
}
