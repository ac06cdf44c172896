//! ADINA-IN commands: nodal coordinates, and a group of shell elements of four nodes.

use std::fmt::Write as _;

use super::super::{
    fault::ExportFault,
    label::{Label, SYSTEM},
    number::real_within,
    quad_mesh::QuadMesh,
    text::ascii,
};
use crate::numerics::cancel::Asking;

/// Keeps a line with a number and three coordinates within 80 columns; what would need more is rounded, to 12 digits at worst.
const WIDTH: usize = 20;

/// Commands that add nodes and elements to a model; a triangle repeats its third node. Material, thickness and loads are the user's.
pub fn adina(mesh: &QuadMesh, label: &Label) -> Result<String, ExportFault> {
    if mesh.faces().is_empty() {
        return Err(ExportFault::Nothing);
    }
    // Writing to a String cannot fail.
    let mut text = String::new();
    let name: String = ascii(&label.name).chars().take(76).collect();
    let _ = writeln!(text, "* {name}\n* {SYSTEM}, {}, lengths in mm\n*", label.written_at.iso_8601());
    text.push_str("COORDINATES NODE SYSTEM=0\n@CLEAR\n");
    for (i, p) in mesh.nodes().iter().enumerate().asking(300) {
        let [x, y, z] = [p.x, p.y, p.z].map(|x| real_within(x, WIDTH));
        let _ = writeln!(text, "{} {x} {y} {z}", i + 1);
    }
    text.push_str("@\n*\nEGROUP SHELL NAME=1\n*\nENODES SUBSTRUC=0 GROUP=1 NNODES=4\n@CLEAR\n");
    for (i, face) in mesh.faces().iter().enumerate().asking(200) {
        let corners = face.corners();
        let _ = write!(text, "{}", i + 1);
        for k in 0..4 {
            let _ = write!(text, " {}", corners[k.min(corners.len() - 1)] + 1);
        }
        text.push('\n');
    }
    text.push_str("@\n");
    Ok(text)
}
