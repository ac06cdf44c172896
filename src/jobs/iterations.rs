//! The use cases of iterations: nodes, their fits, which of them stands, and what was decided.

use std::sync::Arc;

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    amendment::Amendment,
    draft::{AmendmentDraft, DecisionDraft, IterationDraft, RefitDraft},
    fit::{FitRecord, NewFit},
    idempotency::Keyed,
    iteration::{FitSummary, Iteration, ListedIteration, NewIteration},
    measurand::{Measurand, Successors},
    outcome::{Precondition, RepositoryError, Stored},
    page::{Page, PageRequest},
    prior::{Predecessor, Predecessors},
    record::Record,
    rounds::Rounds,
    said::{Choice, DecisionEvent},
    service::Jobs,
};
use flankfit_engine::estimation::Nodes;

impl Jobs {
    /// Stores nodes with their first fit, which stands until somebody chooses another.
    pub async fn add_iteration(
        &self,
        job_id: Uuid,
        draft: IterationDraft,
        keyed: Option<Keyed<NewIteration>>,
    ) -> Result<(Arc<NewIteration>, Stored), RepositoryError> {
        let iteration = Arc::new(self.new_iteration(job_id, draft));
        let receipt = keyed.map(|keyed| keyed.receipt(iteration.clone()));
        self.write(job_id, |repository| async move {
            let stored = repository.insert_iteration(iteration.clone(), receipt).await?;
            Ok((iteration, stored))
        })
        .await
    }

    /// An iteration with its first fit, before it is stored.
    pub(super) fn new_iteration(&self, job_id: Uuid, draft: IterationDraft) -> NewIteration {
        let now = self.now();
        NewIteration {
            id: self.fresh_id(now),
            job_id,
            measurand: draft.measurand,
            details: draft.details,
            created_at: now,
            nodes: draft.nodes.into(),
            fit: NewFit { id: self.fresh_id(now), computed: draft.computed, event: self.event(None, now) },
            records: draft
                .records
                .into_iter()
                .map(|draft| Record { id: self.fresh_id(now), created_at: now, by: self.actor(), draft })
                .collect(),
            expected_gear: draft.expected_gear,
        }
    }

    /// By number, each with the fit that stands.
    pub async fn iterations(&self, job: Uuid, page: PageRequest) -> Result<Page<ListedIteration>, RepositoryError> {
        self.repository.iterations(job, page).await
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

    /// Earlier iterations of the same flank and tooth, oldest first.
    pub async fn predecessors(&self, job: Uuid, wanted: Predecessors) -> Result<Vec<Predecessor>, RepositoryError> {
        self.repository.predecessors(job, wanted).await
    }

    /// Iterations and corrections of a job.
    pub async fn rounds(&self, job: Uuid) -> Result<Rounds, RepositoryError> {
        self.repository.rounds(job).await
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
        let now = self.now();
        let fit =
            Arc::new(NewFit { id: self.fresh_id(now), computed: draft.computed, event: self.event(draft.reason, now) });
        let receipt = keyed.map(|keyed| keyed.receipt(fit.clone()));
        self.write(job, |repository| async move {
            let stored = repository.insert_fit(job, number, fit.clone(), receipt).await?;
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
        let choice = Choice { fit_id, event: self.event(reason, self.now()) };
        self.write(job, |repository| async move { repository.choose(job, number, choice, precondition).await }).await?;
        self.iteration(job, number).await
    }

    /// What is done with the gear after this iteration.
    pub async fn decide(
        &self,
        job: Uuid,
        number: u32,
        draft: DecisionDraft,
        precondition: Precondition,
    ) -> Result<Iteration, RepositoryError> {
        let decision = self.decision(draft, self.now());
        self.write(job, |repository| async move { repository.decide(job, number, decision, precondition).await })
            .await?;
        self.iteration(job, number).await
    }

    fn decision(&self, DecisionDraft { decision, concession, reason }: DecisionDraft, now: Timestamp) -> DecisionEvent {
        DecisionEvent { decision, concession, event: self.event(reason, now) }
    }

    /// Stores a new measurand of the nodes of an iteration, with the repeated fit and the decision.
    pub async fn amend(
        &self,
        job: Uuid,
        number: u32,
        draft: AmendmentDraft,
        precondition: Precondition,
    ) -> Result<Iteration, RepositoryError> {
        let now = self.now();
        let AmendmentDraft { measurand, record, refit, decision } = draft;
        let fit = refit.map(|RefitDraft { computed, reason }| {
            let event = self.event(reason, now);
            NewFit { id: self.fresh_id(now), computed, event }
        });
        let record = Record { id: self.fresh_id(now), created_at: now, by: self.actor(), draft: record };
        let decision = decision.map(|draft| self.decision(draft, now));
        let amendment = Arc::new(Amendment { measurand, record, fit, decision });
        self.write(job, |repository| async move { repository.amend(job, number, amendment, precondition).await })
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
}
