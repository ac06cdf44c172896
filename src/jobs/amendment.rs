//! Changes of the measurand of an iteration's nodes after they were stored.

use super::{fit::NewFit, measurand::Measurand, record::Record, said::DecisionEvent};

/// A change of the measurand of nodes. It is stored in one transaction with the fit whose figures
/// follow from it and with the decision sent with it.
#[derive(Clone, Debug)]
pub struct Amendment {
    /// The new measurand of the nodes.
    pub measurand: Measurand,
    /// Record of the change, with the values before and after.
    pub record: Record,
    /// The chosen fit repeated with the figures of the new measurand; it becomes the chosen one.
    pub fit: Option<NewFit>,
    pub decision: Option<DecisionEvent>,
}

impl Amendment {
    /// Returns by how much the version of the iteration increases: one for the change, each fit,
    /// choice and decision.
    pub fn steps(&self) -> u64 {
        1 + 2 * u64::from(self.fit.is_some()) + u64::from(self.decision.is_some())
    }
}
