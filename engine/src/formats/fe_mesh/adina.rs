//! ADINA-IN commands: nodal coordinates, and a group of shell elements of four nodes.

use std::{io::Write as _, sync::Arc};

use super::super::{
    fault::ExportFault,
    label::{Label, SYSTEM},
    number::real_within,
    pieces::Pieces,
    quad_mesh::QuadMesh,
    text::ascii,
};

/// Keeps a line with a number and three coordinates within 80 columns; what would need more is
/// rounded, to 12 digits at worst.
const WIDTH: usize = 20;

/// Commands that add nodes and elements to a model; a triangle repeats its third node. Material,
/// thickness and loads are the user's.
pub fn adina(mesh: Arc<QuadMesh>, label: &Label) -> Result<Pieces, ExportFault> {
    if mesh.faces().is_empty() {
        return Err(ExportFault::Nothing);
    }
    let name: String = ascii(&label.name).chars().take(76).collect();
    let written = label.written_at.iso_8601();
    let head = format!("* {name}\n* {SYSTEM}, {written}, lengths in mm\n*\nCOORDINATES NODE SYSTEM=0\n@CLEAR\n");
    let (nodes, faces) = (mesh.nodes().len(), mesh.faces().len());
    let elements = Arc::clone(&mesh);
    let file = Pieces::new()
        .text(head)
        .lines(nodes, move |i, out| {
            let p = mesh.nodes()[i];
            let [x, y, z] = [p.x, p.y, p.z].map(|x| real_within(x, WIDTH));
            // Writing to a vector cannot fail.
            let _ = writeln!(out, "{} {x} {y} {z}", i + 1);
        })
        .text("@\n*\nEGROUP SHELL NAME=1\n*\nENODES SUBSTRUC=0 GROUP=1 NNODES=4\n@CLEAR\n")
        .lines(faces, move |i, out| {
            let [a, b, c, d] = elements.faces()[i].four().map(|node| node + 1);
            let _ = writeln!(out, "{} {a} {b} {c} {d}", i + 1);
        });
    Ok(file.text("@\n"))
}
