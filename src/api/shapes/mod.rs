//! Curves and surfaces as they are written and read.

pub mod curve_shape;
pub mod export;
pub mod fault;
pub mod net;
pub mod places;
pub mod point;
pub mod surface_reader;
pub mod surface_shape;

/// Why a method that passes through its points takes nothing of a fit.
pub const THROUGH: &str = "it belongs to methods near points, which fit; this one passes through all of them";
