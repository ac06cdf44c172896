//! Files that other programs read: splines for CAD (IGES, STEP), facets for looking (OBJ, STL, VTK)
//! and nodes with elements for finite elements (tables, Abaqus, ADINA), quality data for
//! statistical process control (Q-DAS); and files that are read: gear measurements, gear models,
//! points.
//!
//! Writers are pure functions from shapes and a [`Label`] to text or bytes, which large files give
//! piece by piece ([`Pieces`]): no clock, no file system, the same bytes for the same input.
//! Lengths are millimetres where a format has a unit. A double is written with the digits that
//! bring back its very bits, and a number that is not finite is never written.
//! docs/reference/export.md describes each format.

#![warn(missing_docs, unnameable_types, unreachable_pub)]

mod archive;
mod axis;
pub mod cad;
mod export;
pub mod fe_mesh;
pub mod file_error;
pub mod gear_facts;
pub mod gear_file;
pub mod gms;
pub mod iges;
pub mod klingelnberg;
pub mod label;
pub mod note;
mod number;
pub mod obj;
pub mod pieces;
mod polar;
pub mod qdas;
pub mod quad_mesh;
pub mod rexs;
pub mod sampling;
pub mod solid_mesh;
mod source;
pub mod step;
pub mod stl;
pub mod table;
mod text;
pub mod topography;
pub mod vtk;

pub use archive::MOST_UNPACKED;
pub use cad::{CadShape, NamedShape};
pub use file_error::{FileError, FilePosition};
pub use gear_facts::{Datum, Difference, GearFacts};
pub use gear_file::GearFile;
pub use label::{Label, UtcTime};
pub use note::{Note, Notes, Remark};
pub use obj::{NamedLine, NamedMesh};
pub use pieces::Pieces;
pub use quad_mesh::{Face, QuadMesh};
pub use source::MOST_BYTES;
pub use table::Table;
pub use topography::Topography;
