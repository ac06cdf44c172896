//! ADINA-IN commands: nodal coordinates, a group of solid elements, sets of nodes.

use std::{io::Write as _, sync::Arc};

use super::{
    super::{
        label::{Label, SYSTEM},
        pieces::Pieces,
    },
    node_lines, title,
};
use flankfit_gear::solid::HexMesh;

/// ADINA counts the nodes of an element from the upper face on.
const ORDER: [usize; 20] = [4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11, 16, 17, 18, 19];

/// Commands that add nodes and elements to a model; a set of nodes for every set of faces, with its
/// name as description.
pub fn adina(mesh: &Arc<HexMesh>, label: &Label) -> Pieces {
    let (name, written) = title(label, 76);
    let head = format!("* {name}\n* {SYSTEM}, {written}, lengths in mm\n*\nCOORDINATES NODE SYSTEM=0\n@CLEAR\n");
    let count = if mesh.is_quadratic() { 20 } else { 8 };
    let elements = Arc::clone(mesh);
    let mut file = node_lines(Pieces::new().text(head), mesh, " ")
        .text(format!("@\n*\nEGROUP THREEDSOLID NAME=1\n*\nENODES SUBSTRUC=0 GROUP=1 NNODES={count}\n@CLEAR\n"))
        .lines(mesh.count(), move |i, out| {
            let element = elements.element(i);
            let _ = write!(out, "{}", i + 1);
            for k in &ORDER[..count] {
                let _ = write!(out, " {}", element[*k] + 1);
            }
            out.push(b'\n');
        })
        .text("@\n");
    for (k, set) in mesh.sets().iter().enumerate() {
        let nodes = mesh.nodes_of(set);
        let head = format!("*\nNODESET NAME={} ALL-EXT=NO DESCRIPT='{}' OPTION=NODE\n@CLEAR\n", k + 1, set.name);
        file = file
            .text(head)
            .lines(nodes.len(), move |i, out| {
                let _ = writeln!(out, "{} 0 1", nodes[i] + 1);
            })
            .text("@\n");
    }
    file
}
