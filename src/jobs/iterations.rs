//! The use cases of iterations: nodes, their fits, choices and decisions.

use std::sync::Arc;

use jiff::Timestamp;
use uuid::Uuid;

use crate::jobs::*;

impl Jobs {
    /// Stores nodes with their first fit, which is the chosen one until somebody chooses another.
    pub async fn add_iteration(
        &self,
        job_id: Uuid,
        draft: IterationDraft,
        keyed: Option<Keyed<NewIteration>>,
    ) -> Result<(Arc<NewIteration>, Stored), RepositoryError> {
        let iteration = Arc::new(self.new_iteration(job_id, draft));
        let receipt = keyed.map(|keyed| keyed.receipt(iteration.clone()));
        let stored = self.write(job_id, self.repository.insert_iteration(iteration.clone(), receipt)).await?;
        Ok((iteration, stored))
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
            fit: self.new_fit(RefitDraft { computed: draft.computed, reason: None }, now),
            records: draft.records.into_iter().map(|draft| self.new_record(draft, now)).collect(),
            expected_gear: draft.expected_gear,
        }
    }

    /// Stores another fit of stored nodes. It is not the chosen one until it is chosen.
    pub async fn add_fit(
        &self,
        job: Uuid,
        number: u32,
        draft: RefitDraft,
        keyed: Option<Keyed<NewFit>>,
    ) -> Result<(Arc<NewFit>, Stored), RepositoryError> {
        let now = self.now();
        let fit = Arc::new(self.new_fit(draft, now));
        let receipt = keyed.map(|keyed| keyed.receipt(fit.clone()));
        let stored = self.write(job, self.repository.insert_fit(job, number, fit.clone(), receipt)).await?;
        Ok((fit, stored))
    }

    fn new_fit(&self, RefitDraft { computed, reason }: RefitDraft, now: Timestamp) -> NewFit {
        NewFit { id: self.fresh_id(now), computed, event: self.event(reason, now) }
    }

    fn new_record(&self, draft: RecordDraft, now: Timestamp) -> Record {
        Record { id: self.fresh_id(now), created_at: now, by: self.actor(), draft }
    }

    /// Stores a record of an iteration, in addition to those it has.
    pub async fn add_record(
        &self,
        job: Uuid,
        number: u32,
        draft: RecordDraft,
        keyed: Option<Keyed<Record>>,
    ) -> Result<(Arc<Record>, Stored), RepositoryError> {
        let record = Arc::new(self.new_record(draft, self.now()));
        let receipt = keyed.map(|keyed| keyed.receipt(record.clone()));
        let stored = self.write(job, self.repository.insert_record(job, number, record.clone(), receipt)).await?;
        Ok((record, stored))
    }

    /// Makes a fit of the iteration the chosen one.
    pub async fn choose_fit(
        &self,
        job: Uuid,
        number: u32,
        fit_id: Uuid,
        reason: Option<String>,
        precondition: Precondition,
    ) -> Result<Iteration, RepositoryError> {
        let choice = Choice { fit_id, event: self.event(reason, self.now()) };
        self.write(job, self.repository.choose(job, number, choice, precondition)).await?;
        self.iteration(job, number).await
    }

    /// Stores a decision on the gear after this iteration.
    pub async fn decide(
        &self,
        job: Uuid,
        number: u32,
        draft: DecisionDraft,
        precondition: Precondition,
    ) -> Result<Iteration, RepositoryError> {
        let decision = self.decision(draft, self.now());
        self.write(job, self.repository.decide(job, number, decision, precondition)).await?;
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
        let fit = refit.map(|draft| self.new_fit(draft, now));
        let (record, decision) = (self.new_record(record, now), decision.map(|draft| self.decision(draft, now)));
        let amendment = Arc::new(Amendment { measurand, record, fit, decision });
        self.write(job, self.repository.amend(job, number, amendment, precondition)).await?;
        self.iteration(job, number).await
    }
}
