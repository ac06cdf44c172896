//! Earlier iterations of a flank, on which a prior may stand.

use uuid::Uuid;

use super::measurand::Measurand;

/// An earlier iteration of the same flank and tooth.
#[derive(Clone, Debug, PartialEq)]
pub struct Predecessor {
    pub number: u32,
    pub measurand: Measurand,
    /// The chosen fit.
    pub fit_id: Uuid,
}

/// Which of them: numbers from `from` on and below `before`, and of these the last `most`.
#[derive(Clone, Debug, PartialEq)]
pub struct Predecessors {
    pub of: Measurand,
    pub from: u32,
    /// The iteration that they precede; `None` for one that is about to be stored.
    pub before: Option<u32>,
    pub most: usize,
}
