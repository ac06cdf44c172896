//! Common parts of requests and responses with curves and surfaces, and their files.

pub mod export;
pub mod fault;
pub mod places;

/// Why a method that passes through its points takes nothing of a fit.
pub const THROUGH: &str = "it belongs to methods that fit points; this one passes through all of them";
