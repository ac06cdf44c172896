//! Gear jobs over real HTTP.

pub mod app;
pub mod audit;
mod command_line;
mod concurrency;
mod conditional;
mod estimators;
pub mod events;
mod examples;
mod idempotency;
pub mod kill;
mod lean;
mod life;
mod list;
pub mod long;
mod measurand;
mod plant;
mod previews;
mod refusals;
mod replicas;
mod seals;
mod several;
pub mod socket;
mod stream_kill;
mod stream_opening;
pub mod streams;
mod tenants;
mod wakes;
