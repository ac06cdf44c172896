//! Gear jobs over real HTTP.

mod app;
mod command_line;
mod concurrency;
mod conditional;
mod examples;
mod idempotency;
mod kill;
mod life;
mod refusals;
