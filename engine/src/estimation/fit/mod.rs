//! The way of a fit: nodes → design → factor → scaled columns → spectrum → λ* → estimate → report.

mod conclude;
mod cost;
mod plan;
mod run;

pub(crate) use conclude::report;
pub use cost::is_short;
pub use plan::{Plan, Plans};
pub(crate) use run::fit_together;
pub use run::{fit, fit_remembering};
