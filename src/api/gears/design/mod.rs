//! What follows from a gear's data: geometry, tooth profile, flanks, tolerances.

pub mod flank;
pub mod geometry;
pub mod modification;
pub mod places;
pub mod profile;
pub mod solid_mesh;
pub mod tolerances;
