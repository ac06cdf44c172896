//! Simulated corrections.

pub mod closed_loop;
mod faults;
pub mod request;
pub mod result;
