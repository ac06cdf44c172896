//! Gear jobs: iterations, their fits and records, trace, events.

pub mod acceptance;
pub mod amendments;
pub mod audit;
pub mod carried;
pub mod events;
pub mod fits;
pub mod import;
pub mod iteration_requests;
pub mod iterations;
pub mod job;
pub mod job_list;
pub mod listed_iterations;
pub mod problem;
pub mod purge;
pub mod records;
pub mod seals;
pub mod trace;
