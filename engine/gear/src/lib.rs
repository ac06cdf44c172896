//! The gear flank: nominal, modified, measured, evaluated and corrected (ISO 21771, ISO 1328-1).
//!
//! Conventions. Lengths in mm, deviations in µm, angles in radians.
//! The z axis is the gear's and points to the viewer, the tooth of a section z = 0 points up (+y)
//! and is symmetrical about the y axis. *Left* and *right* flank are those that the viewer sees on
//! the left (−x) and on the right of the tooth. A deviation is positive where material protrudes
//! from the nominal flank.
//!
//! Nothing here solves a least-squares problem of its own: lines, surfaces, registration and
//! correction are fits of [`flankfit_estimation`].

#![warn(missing_docs, unnameable_types, unreachable_pub)]

pub mod check;
pub mod correction;
pub mod data;
pub mod deviation;
pub mod evaluation;
pub mod flank_grid;
pub mod generation;
pub mod geometry;
pub mod involute;
pub mod modification;
pub mod profile_axis;
pub mod registration;
pub mod simulation;
pub mod solid;
pub mod tolerance;
pub mod tooth;
pub mod trace;
pub mod warning;

pub use data::{Gear, GearData, Hand, Side, Tool};
pub use flank_grid::{FlankGrid, GridSpec};
pub use geometry::Geometry;
pub use modification::Modifications;
pub use profile_axis::ProfileAxis;
pub use trace::{Kind, Trace};
