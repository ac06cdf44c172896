//! The use cases of iterations: nodes, their fits, which of them stands, and what was decided.

use std::sync::Arc;

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    amendment::Amendment,
    draft::{AmendmentDraft, DecisionDraft, IterationDraft, RefitDraft},
    fit::NewFit,
    idempotency::Keyed,
    iteration::{Iteration, NewIteration},
    outcome::{Precondition, RepositoryError, Stored},
    record::Record,
    said::{Choice, DecisionEvent},
    service::Jobs,
};

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
}
