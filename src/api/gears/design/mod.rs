//! Quantities derived from the data of a gear: geometry, tooth profile, flanks, tolerances.

pub mod flank;
pub mod geometry;
pub mod modification;
pub mod places;
pub mod profile;
pub mod solid_mesh;
pub mod tolerances;
