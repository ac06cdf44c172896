//! What is said of an iteration's nodes after they were stored.

use super::{fit::NewFit, measurand::Measurand, record::Record, said::DecisionEvent};

/// A change of what nodes are of. It is stored in one transaction with the fit that has figures by
/// it and with the decision that was taken with it.
#[derive(Clone, Debug)]
pub struct Amendment {
    /// What the nodes are of from now on.
    pub measurand: Measurand,
    /// That it was changed, from what to what.
    pub record: Record,
    /// The chosen fit once more, with figures by the new measurand. It is chosen.
    pub fit: Option<NewFit>,
    pub decision: Option<DecisionEvent>,
}

impl Amendment {
    /// By how many the version of the iteration grows: one for the change, each fit, choice and
    /// decision.
    pub fn steps(&self) -> u64 {
        1 + 2 * u64::from(self.fit.is_some()) + u64::from(self.decision.is_some())
    }
}
