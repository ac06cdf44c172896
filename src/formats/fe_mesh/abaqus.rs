//! Abaqus input: `*NODE` and `*ELEMENT` of shells, S4 and, where a side has no length, S3.

use std::fmt::Write as _;

use super::super::{
    fault::ExportFault,
    label::{Label, SYSTEM},
    number::real_within,
    quad_mesh::{Face, QuadMesh},
    text::ascii,
};
use crate::numerics::cancel::Asking;

/// The columns that Abaqus takes for a number; what would need more is rounded, to 12 digits at worst.
const WIDTH: usize = 20;

/// Nodes in the set `NODES`, elements in the set `FLANK`. Section, material and steps are the user's.
pub fn abaqus(mesh: &QuadMesh, label: &Label) -> Result<String, ExportFault> {
    if mesh.faces().is_empty() {
        return Err(ExportFault::Nothing);
    }
    // Writing to a String cannot fail.
    let mut text = String::new();
    let name: String = ascii(&label.name).chars().take(80).collect();
    let _ = writeln!(text, "*HEADING\n{SYSTEM}: {name}\n** {}, lengths in mm", label.written_at.iso_8601());
    text.push_str("*NODE, NSET=NODES\n");
    for (i, p) in mesh.nodes().iter().enumerate().asking(300) {
        let [x, y, z] = [p.x, p.y, p.z].map(|x| real_within(x, WIDTH));
        let _ = writeln!(text, "{}, {x}, {y}, {z}", i + 1);
    }
    for (kind, corners) in [("S4", 4), ("S3", 3)] {
        let mut elements = mesh.faces().iter().enumerate().filter(|(_, f)| f.corners().len() == corners).peekable();
        if elements.peek().is_some() {
            let _ = writeln!(text, "*ELEMENT, TYPE={kind}, ELSET=FLANK");
        }
        for (i, face) in elements.asking(200) {
            let _ = write!(text, "{}", i + 1);
            for node in Face::corners(face) {
                let _ = write!(text, ", {}", node + 1);
            }
            text.push('\n');
        }
    }
    Ok(text)
}
