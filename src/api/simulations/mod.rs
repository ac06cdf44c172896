//! Simulated corrections.

pub mod closed_loop;
mod faults;
