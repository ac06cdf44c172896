//! Abaqus input: `*NODE` and `*ELEMENT` of shells, S4 and, where a side has no length, S3.

use std::{io::Write as _, sync::Arc};

use super::{
    super::{
        fault::ExportFault,
        label::{Label, SYSTEM},
        pieces::Pieces,
        quad_mesh::QuadMesh,
    },
    coordinates::{node_lines, title},
};

/// Nodes in the set `NODES`, elements in the set `FLANK`. Section, material and steps are the
/// user's.
pub fn abaqus(mesh: Arc<QuadMesh>, label: &Label) -> Result<Pieces, ExportFault> {
    let (name, written) = title(&mesh, label, 80)?;
    let head = format!("*HEADING\n{SYSTEM}: {name}\n** {written}, lengths in mm\n*NODE, NSET=NODES\n");
    let mut file = node_lines(Pieces::new().text(head), Arc::clone(&mesh), ", ");
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
