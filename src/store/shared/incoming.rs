//! Iterations that are inserted together.

use uuid::Uuid;

use super::{
    audit::target,
    operation::{Asked, InsertIteration, InsertRuns, Key, key_of},
};
use crate::jobs::{
    Lease, NewIteration, NewRun, Receipt, Tenant,
    audit::{Action, By, Prepared},
};

/// An iteration about to be stored, with the caller whose tenant's job it names.
#[derive(Clone, Copy)]
pub struct Incoming<'a> {
    pub by: By<'a>,
    pub iteration: &'a NewIteration,
    pub receipt: Option<&'a Receipt>,
    pub prepared: &'a Prepared,
    /// The stream that it was.
    pub stream: Option<Uuid>,
}

impl<'a> Incoming<'a> {
    pub fn of(asked: &'a Asked<InsertIteration>) -> Self {
        let InsertIteration { iteration, receipt } = &asked.write;
        let (receipt, prepared) = (receipt.as_ref(), &asked.prepared[0]);
        Incoming { by: asked.by(), iteration, receipt, prepared, stream: None }
    }

    pub fn tenant(&self) -> &'a Tenant {
        &self.by.caller.tenant
    }

    pub fn key(&self) -> Option<Key<'a>> {
        self.receipt.map(|receipt| key_of(self.tenant(), receipt))
    }

    /// Under which lease, where a task asks for it.
    pub fn lease(&self) -> Option<Lease> {
        self.receipt.and_then(|receipt| receipt.request.lease)
    }

    /// What is done, and to what.
    pub fn deed(&self, number: u32) -> (Action, String) {
        let action = if self.stream.is_some() { Action::FinishStream } else { Action::AddIteration };
        (action, target::iteration(self.iteration.job_id, number))
    }
}

impl Asked<InsertRuns> {
    /// Each job with its iterations, the entry of the job and those of the iterations.
    pub fn by_runs(&self) -> impl Iterator<Item = (&NewRun, &Prepared, Vec<Incoming<'_>>)> {
        let mut prepared = self.prepared.iter();
        self.write.runs.iter().filter_map(move |run| {
            let of_job = prepared.next()?;
            let incoming = run.iterations.iter().zip(&mut prepared).map(|(iteration, prepared)| Incoming {
                by: self.by(),
                iteration,
                receipt: None,
                prepared,
                stream: None,
            });
            Some((run, of_job, incoming.collect()))
        })
    }
}
