//! Iterations that are inserted together.

use super::operation::{Asked, InsertIteration, Key, key_of};
use crate::jobs::{NewIteration, Receipt, Tenant};

/// An iteration about to be stored, with the tenant whose job it names.
#[derive(Clone, Copy)]
pub struct Incoming<'a> {
    pub tenant: &'a Tenant,
    pub iteration: &'a NewIteration,
    pub receipt: Option<&'a Receipt>,
}

impl<'a> Incoming<'a> {
    pub fn of(Asked { caller, write: InsertIteration { iteration, receipt } }: &'a Asked<InsertIteration>) -> Self {
        Incoming { tenant: &caller.tenant, iteration, receipt: receipt.as_ref() }
    }

    pub fn key(&self) -> Option<Key<'a>> {
        self.receipt.map(|receipt| key_of(self.tenant, receipt))
    }
}
