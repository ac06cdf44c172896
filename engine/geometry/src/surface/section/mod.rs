//! Sections of surfaces by planes.
//!
//! The height of the surface over the plane is a function of the parameters, and the section is
//! where it is 0. Of splines that function, times the weight, is a polynomial between knots, whose
//! Bernstein coefficients rule cells of parameters out or show that one line passes. Between cells
//! that they do not decide lie places without slope, where the plane touches the surface or
//! branches cross. The lines are refined until cubics with the true tangents, or chords, are within
//! the tolerance, and joined where they go on: on the next piece, across a seam, through a pole.
//!
//! Coons patches of rational curves and Gregory patches with two twists at a corner are no splines:
//! there the second derivatives are sampled instead, and a loop much smaller than a cell may be
//! missed. A point in which the plane meets nothing but a border is not reported.
//!
//! Ref.: Patrikalakis and Maekawa, Shape Interrogation for Computer Aided Design and Manufacturing,
//! ch. 4 and 5.

mod borders;
mod boxes;
mod cells;
mod chain;
mod fault;
mod field;
mod form;
mod heights;
mod join;
mod line;
mod march;
mod mesh;
mod near;
mod plane;
mod result;
mod rows;
mod sections;
mod spans;

pub use fault::SectionFault;
pub use line::{Description, SectionPoint};
pub use mesh::{Family, MeshOfSections, NoMesh, at_right_angles, mesh_of_sections};
pub use plane::Plane;
pub use result::{Section, SectionCurve};
pub use sections::Sections;
