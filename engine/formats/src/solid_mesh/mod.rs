//! Hexahedra of a [`HexMesh`] for finite elements: Abaqus and CalculiX, ADINA, Gmsh.
//!
//! Nodes and elements are numbered from 1 in the order of the mesh; each file has those named sets
//! of faces that its program supports. Lengths are mm. Material and loads are the user's.

mod abaqus;
mod adina;
mod gmsh;

pub use abaqus::abaqus;
pub use adina::adina;
pub use gmsh::gmsh;

use std::{io::Write as _, sync::Arc};

use super::{label::Label, number::real_within, pieces::Pieces, text::ascii};
use flankfit_gear::solid::HexMesh;

/// Columns of a number, as for shells.
const WIDTH: usize = 20;

/// The name in at most so many ASCII characters, and when it was written.
fn title(label: &Label, most: usize) -> (String, String) {
    (ascii(&label.name).chars().take(most).collect(), label.written_at.iso_8601())
}

/// A line for every node: its number and its coordinates.
fn node_lines(file: Pieces, mesh: &Arc<HexMesh>, separator: &'static str) -> Pieces {
    let mesh = Arc::clone(mesh);
    file.lines(mesh.nodes().len(), move |i, out| {
        let p = mesh.nodes()[i];
        let [x, y, z] = [p.x, p.y, p.z].map(|x| real_within(x, WIDTH));
        // Writing to a vector cannot fail.
        let _ = writeln!(out, "{}{separator}{x}{separator}{y}{separator}{z}", i + 1);
    })
}
