//! Requests that are answered later (`Prefer: respond-async`), for every operation that the
//! document says takes it ([`super::openapi::long`]).
//!
//! A request is first read and checked as any other: its handler runs until computing begins
//! (`Handle::for_checks`), so whatever is wrong with it is told at once, and so is what takes no
//! computing. Then it is kept as a task with its whole text (`begin`), and 202 tells where.
//! Whichever process takes the task hands the kept request to the very same handler (`runner`), so
//! no operation is written twice. What that answers is kept for an hour (`endpoints`,
//! `answer`, `packed`).

mod answer;
mod begin;
mod endpoints;
mod packed;
mod prefer;
mod replay;
mod runner;
mod running;

pub use begin::respond_async;
pub use endpoints::group;
pub use prefer::Preference;
pub use runner::run;
pub use running::Running;
