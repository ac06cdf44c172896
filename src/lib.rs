//! flankfit: robust parametric estimation of tooth-flank surfaces, as an HTTP service.

pub mod estimation;
pub mod geometry;
pub mod numerics;
