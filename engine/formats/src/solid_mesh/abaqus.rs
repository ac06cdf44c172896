//! Abaqus and CalculiX input: nodes, elements, sets of nodes and surfaces.

use std::{io::Write as _, sync::Arc};

use super::{
    super::{
        label::{Label, SYSTEM},
        pieces::Pieces,
    },
    node_lines, title,
};
use flankfit_gear::solid::HexMesh;

/// Entries of a line of a set, and nodes of an element on its first line: both programs take 16.
const ENTRIES: usize = 15;

/// Nodes in the set `NODES`, elements (C3D20, or C3D8I, which do not lock in bending) in the set
/// `GEAR`; every set of faces as a surface and, with `N_` before its name, as a set of nodes.
pub fn abaqus(mesh: &Arc<HexMesh>, label: &Label) -> Pieces {
    let (name, written) = title(label, 80);
    let head = format!("*HEADING\n{SYSTEM}: {name}\n** {written}, lengths in mm\n*NODE, NSET=NODES\n");
    let kind = if mesh.is_quadratic() { "C3D20" } else { "C3D8I" };
    let elements = Arc::clone(mesh);
    let mut file = node_lines(Pieces::new().text(head), mesh, ", ")
        .text(format!("*ELEMENT, TYPE={kind}, ELSET=GEAR\n"))
        .lines(mesh.count(), move |i, out| {
            let _ = write!(out, "{}", i + 1);
            for (k, node) in elements.element(i).iter().enumerate() {
                let _ = write!(out, "{} {}", if k == ENTRIES { ",\n" } else { "," }, node + 1);
            }
            out.push(b'\n');
        });
    for (k, set) in mesh.sets().iter().enumerate() {
        let (own, of_nodes) = (Arc::clone(mesh), mesh.nodes_of(set));
        file = file
            .text(format!("*NSET, NSET=N_{}\n", set.name))
            .lines(of_nodes.len(), move |i, out| {
                let _ = writeln!(out, "{},", of_nodes[i] + 1);
            })
            .text(format!("*SURFACE, NAME={}, TYPE=ELEMENT\n", set.name))
            .lines(set.faces.len(), move |i, out| {
                let face = own.sets()[k].faces[i];
                let _ = writeln!(out, "{}, S{}", face.element + 1, face.face + 1);
            });
    }
    file
}
