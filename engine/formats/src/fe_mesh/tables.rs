//! Coordinates and connectivity as two CSV tables.

use std::{io::Write as _, sync::Arc};

use super::super::{number::real, pieces::Pieces, quad_mesh::QuadMesh};

/// `node,x,y,z`, lengths in mm, to the last bit.
pub fn nodes_csv(mesh: Arc<QuadMesh>) -> Pieces {
    let count = mesh.nodes().len();
    Pieces::new().text("node,x,y,z\n").lines(count, move |i, out| {
        let p = mesh.nodes()[i];
        // Writing to a vector cannot fail.
        let _ = writeln!(out, "{},{},{},{}", i + 1, real(p.x), real(p.y), real(p.z));
    })
}

/// `element,node_1,node_2,node_3,node_4`; a triangle repeats its third node.
///
/// ```
/// use flankfit_formats::{QuadMesh, fe_mesh::elements_csv};
/// use flankfit_geometry::{space::{Dimension, Vector}, surface::BezierSurface};
///
/// let square = [[0.0, 1.0]; 2];
/// let heights = vec![Vector::zeros(); 4];
/// let flat = BezierSurface::new([2, 2], square, Dimension::Graph, heights, None)?;
/// let mesh = QuadMesh::of_surfaces(&[&flat], [1, 1], 0.0, false)?;
/// let file = String::from_utf8(elements_csv(mesh.into()).whole())?;
/// let (head, element) = file.split_once('\n').unwrap();
/// assert_eq!(head, "element,node_1,node_2,node_3,node_4");
/// assert!(element.starts_with("1,") && element.lines().count() == 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn elements_csv(mesh: Arc<QuadMesh>) -> Pieces {
    let count = mesh.faces().len();
    Pieces::new().text("element,node_1,node_2,node_3,node_4\n").lines(count, move |i, out| {
        let [a, b, c, d] = mesh.faces()[i].four().map(|node| node + 1);
        let _ = writeln!(out, "{},{a},{b},{c},{d}", i + 1);
    })
}
