//! Iterations that are inserted together.

use uuid::Uuid;

use super::{keys::OwnedKey, subject, write::Asked};
use crate::jobs::{
    NewIteration, Receipt, Tenant,
    audit::{Action, By},
};

/// An iteration about to be stored, with the caller whose tenant's job it names.
#[derive(Clone, Copy)]
pub struct Incoming<'a> {
    pub by: By<'a>,
    pub iteration: &'a NewIteration,
    pub receipt: Option<&'a Receipt>,
    pub key: Option<&'a OwnedKey>,
    /// The stream that it was.
    pub stream: Option<Uuid>,
}

impl<'a> Incoming<'a> {
    pub fn of(asked: &'a Asked, iteration: &'a NewIteration, receipt: Option<&'a Receipt>) -> Self {
        let key = asked.key.as_ref().filter(|_| receipt.is_some());
        Incoming { by: asked.by(), iteration, receipt, key, stream: None }
    }

    pub fn tenant(&self) -> &'a Tenant {
        &self.by.caller.tenant
    }

    /// Returns the action, and the path of the iteration.
    pub fn deed(&self, number: u32) -> (Action, String) {
        let action = if self.stream.is_some() { Action::FinishStream } else { Action::AddIteration };
        (action, subject::iteration(self.iteration.job_id, number))
    }
}
