//! Gmsh's own format (MSH 2.2, text), which many programs read.

use std::{io::Write as _, sync::Arc};

use super::{
    super::{
        label::{Label, SYSTEM},
        pieces::Pieces,
    },
    node_lines, title,
};
use flankfit_gear::solid::{HexFace, HexMesh};

/// Gmsh counts edges by their first, then their second end.
const ORDER: [usize; 20] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14];

/// Hexahedra in the physical group `GEAR`; the faces of every set as quadrilaterals, which point
/// outwards, in a group of its name.
pub fn gmsh(mesh: &Arc<HexMesh>, label: &Label) -> Pieces {
    let (name, written) = title(label, 80);
    let (solid, face) = if mesh.is_quadratic() { (17, 16) } else { (5, 3) };
    let nodes = if mesh.is_quadratic() { 20 } else { 8 };
    let groups = mesh.sets().len();
    let mut head = format!("$Comments\n{SYSTEM}: {name}\n{written}, lengths in mm\n$EndComments\n");
    head += &format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{}\n3 1 \"GEAR\"\n", groups + 1);
    for (k, set) in mesh.sets().iter().enumerate() {
        head += &format!("2 {} \"{}\"\n", k + 2, set.name);
    }
    head += &format!("$EndPhysicalNames\n$Nodes\n{}\n", mesh.nodes().len());
    let faces: usize = mesh.sets().iter().map(|set| set.faces.len()).sum();
    let elements = Arc::clone(mesh);
    let mut file = node_lines(Pieces::new().text(head), mesh, " ")
        .text(format!("$EndNodes\n$Elements\n{}\n", mesh.count() + faces))
        .lines(mesh.count(), move |i, out| {
            let element = elements.element(i);
            let _ = write!(out, "{} {solid} 2 1 1", i + 1);
            for k in &ORDER[..nodes] {
                let _ = write!(out, " {}", element[*k] + 1);
            }
            out.push(b'\n');
        });
    let mut first = mesh.count() + 1;
    for (k, set) in mesh.sets().iter().enumerate() {
        let own = Arc::clone(mesh);
        let number = first;
        first += set.faces.len();
        file = file.lines(set.faces.len(), move |i, out| {
            let at: HexFace = own.sets()[k].faces[i];
            let _ = write!(out, "{} {face} 2 {group} {group}", number + i, group = k + 2);
            for node in own.face(at) {
                let _ = write!(out, " {}", node + 1);
            }
            out.push(b'\n');
        });
    }
    file.text("$EndElements\n")
}
