//! Abaqus input: `*NODE` and `*ELEMENT` of shells, S4 and, where a side has no length, S3.

use std::{io::Write as _, sync::Arc};

use super::super::{
    fault::ExportFault,
    label::{Label, SYSTEM},
    number::real_within,
    pieces::Pieces,
    quad_mesh::QuadMesh,
    text::ascii,
};

/// The columns that Abaqus takes for a number; what would need more is rounded, to 12 digits at
/// worst.
const WIDTH: usize = 20;

/// Nodes in the set `NODES`, elements in the set `FLANK`. Section, material and steps are the
/// user's.
pub fn abaqus(mesh: Arc<QuadMesh>, label: &Label) -> Result<Pieces, ExportFault> {
    if mesh.faces().is_empty() {
        return Err(ExportFault::Nothing);
    }
    let name: String = ascii(&label.name).chars().take(80).collect();
    let written = label.written_at.iso_8601();
    let head = format!("*HEADING\n{SYSTEM}: {name}\n** {written}, lengths in mm\n*NODE, NSET=NODES\n");
    let nodes = Arc::clone(&mesh);
    let mut file = Pieces::new().text(head).lines(mesh.nodes().len(), move |i, out| {
        let p = nodes.nodes()[i];
        let [x, y, z] = [p.x, p.y, p.z].map(|x| real_within(x, WIDTH));
        // Writing to a vector cannot fail.
        let _ = writeln!(out, "{}, {x}, {y}, {z}", i + 1);
    });
    for (kind, count) in [("S4", 4), ("S3", 3)] {
        if mesh.faces().iter().any(|face| face.corners().len() == count) {
            file = file.text(format!("*ELEMENT, TYPE={kind}, ELSET=FLANK\n"));
        }
        let elements = Arc::clone(&mesh);
        file = file.lines(mesh.faces().len(), move |i, out| {
            let corners = elements.faces()[i].corners();
            if corners.len() == count {
                let _ = write!(out, "{}", i + 1);
                for node in corners {
                    let _ = write!(out, ", {}", node + 1);
                }
                out.push(b'\n');
            }
        });
    }
    Ok(file)
}
