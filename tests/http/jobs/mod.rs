//! Gear jobs over real HTTP.

mod app;
mod command_line;
mod concurrency;
mod conditional;
mod estimators;
mod events;
mod examples;
mod idempotency;
mod kill;
mod lean;
mod life;
mod measurand;
mod refusals;
mod socket;
mod stream_kill;
mod stream_opening;
mod streams;
