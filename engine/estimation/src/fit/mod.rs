//! The way of a fit: nodes → design → factor → scaled columns → spectrum → λ* → estimate → report.

mod checks;
mod conclude;
mod cost;
mod error_checks;
mod error_course;
mod error_models;
mod estimable;
mod forms;
mod inferred;
mod influence;
mod intervals;
mod norm_limit;
mod plan;
mod position_errors;
mod predict;
mod run;
mod shape;
mod sums;

pub(crate) use conclude::report;
pub use cost::is_short;
pub use error_checks::requested_models;
pub use plan::Plans;
pub(crate) use predict::check as check_predictions;
pub(crate) use run::fit_together;
pub(super) use run::{fit, fit_remembering};
