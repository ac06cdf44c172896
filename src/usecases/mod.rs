//! Use cases: what a request does between its reading and its response, with the store, the
//! workers and the memory budget. No HTTP here, and no SQL.

pub mod budget;
pub mod correct;
pub mod decide;
pub mod entered;
pub mod fit;
pub mod import;
pub mod iterate;
pub mod nodes;
pub mod prior;
mod representative;
pub mod rounds;

use budget::Budget;
use flankfit_engine::estimation::Plans;

use crate::{jobs::Jobs, pool::WorkPool};

/// Dependencies of a use case.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// Jobs of the caller's tenant.
    pub jobs: &'a Jobs,
    pub pool: &'a WorkPool,
    pub budget: &'a Budget,
    pub plans: &'a Plans,
}

/// Names that most files of use cases use.
mod prelude {
    pub use flankfit_engine::estimation::{FitSpec, Nodes};
    pub use std::sync::Arc;
    pub use uuid::Uuid;

    pub use super::{Context, budget::WithPermit, nodes};
    pub use crate::{
        api::{faults::Faults, gears::fit_figures::OfFlank, problem::Problem},
        jobs::{Computed, RecordKind},
    };
}
