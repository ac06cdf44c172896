//! Simulated corrections.

pub mod closed_loop;
pub mod request;
pub mod result;
