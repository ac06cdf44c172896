//! Abaqus input: `*NODE` and `*ELEMENT` of shells, S4 and, where a side has no length, S3.

use flankfit_numerics::check::Faults;
use std::{io::Write as _, sync::Arc};

use super::{
    super::{
        label::{Label, SYSTEM},
        pieces::Pieces,
        quad_mesh::QuadMesh,
    },
    coordinates::{node_lines, title},
};

/// Nodes in the set `NODES`, elements in the set `FLANK`. Section, material and steps are the
/// user's.
///
/// ```
/// use flankfit_formats::{Label, QuadMesh, UtcTime, fe_mesh::abaqus};
/// use flankfit_geometry::{space::{Dimension, Vector}, surface::BezierSurface};
///
/// let square = [[0.0, 1.0]; 2];
/// let heights = vec![Vector::zeros(); 4];
/// let flat = BezierSurface::new([2, 2], square, Dimension::Graph, heights, None)?;
/// let mesh = QuadMesh::of_surfaces(&[&flat], [1, 1], 0.0, false)?;
/// let label = Label {
///     name: "flat".into(),
///     author: String::new(),
///     organization: String::new(),
///     written_at: UtcTime::epoch(),
/// };
/// let file = String::from_utf8(abaqus(mesh.into(), &label)?.whole())?;
/// assert!(file.to_uppercase().contains("*NODE, NSET=NODES"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn abaqus(mesh: Arc<QuadMesh>, label: &Label) -> Result<Pieces, Faults> {
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
