//! Files that other programs read: splines for CAD (IGES, STEP), facets for looking (OBJ, STL, VTK) and nodes with elements for
//! finite elements (tables, Abaqus, ADINA).
//!
//! Writers are pure functions from shapes and a [`Label`] to text or bytes: no clock, no file system, the same bytes for the same
//! input. Lengths are millimetres where a format has a unit. A double is written with the digits that bring back its very bits, and
//! a number that is not finite is never written. docs/export.md tells users what to expect of each format.

mod axis;
pub mod cad;
pub mod fault;
pub mod fe_mesh;
pub mod iges;
pub mod label;
mod number;
pub mod obj;
mod polar;
pub mod quad_mesh;
pub mod sampling;
pub mod step;
pub mod stl;
mod text;
pub mod vtk;

pub use cad::{CadShape, NamedShape};
pub use fault::ExportFault;
pub use label::{Label, Moment};
pub use obj::{NamedLine, NamedMesh};
pub use quad_mesh::{Face, QuadMesh};
pub use sampling::SurfaceSample;
