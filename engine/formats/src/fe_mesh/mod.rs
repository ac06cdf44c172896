//! Nodes and elements for finite elements, from a [`QuadMesh`](super::QuadMesh) whose borders are
//! joined: two tables, Abaqus, ADINA.
//!
//! Nodes and elements are numbered from 1 in the order of the mesh. Elements turn counter-clockwise
//! seen from where the surface's normal points to. Lengths are mm: neither program knows units, so
//! its user's other numbers have to go with that.

mod abaqus;
mod adina;
mod coordinates;
mod tables;

pub use abaqus::abaqus;
pub use adina::adina;
pub use tables::{elements_csv, nodes_csv};
