//! Iterations that are inserted together.

use super::{keys::OwnedKey, prelude::*, subject, write::Request};
use crate::jobs::audit::By;

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
    pub fn of(request: &'a Request, iteration: &'a NewIteration, receipt: Option<&'a Receipt>) -> Self {
        let key = request.key.as_ref().filter(|_| receipt.is_some());
        Incoming { by: request.by(), iteration, receipt, key, stream: None }
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
