//! Coordinates and connectivity as two CSV tables.

use std::fmt::Write as _;

use super::super::{number::real, quad_mesh::QuadMesh};
use crate::numerics::cancel::Asking;

/// `node,x,y,z`, lengths in mm, to the last bit.
pub fn nodes_csv(mesh: &QuadMesh) -> String {
    // Writing to a String cannot fail.
    let mut text = "node,x,y,z\n".to_owned();
    for (i, p) in mesh.nodes().iter().enumerate().asking(300) {
        let _ = writeln!(text, "{},{},{},{}", i + 1, real(p.x), real(p.y), real(p.z));
    }
    text
}

/// `element,node_1,node_2,node_3,node_4`; a triangle repeats its third node.
pub fn elements_csv(mesh: &QuadMesh) -> String {
    let mut text = "element,node_1,node_2,node_3,node_4\n".to_owned();
    for (i, face) in mesh.faces().iter().enumerate().asking(200) {
        let corners = face.corners();
        let last = corners[corners.len() - 1];
        let fourth = corners.get(3).unwrap_or(&last);
        let _ = writeln!(text, "{},{},{},{},{}", i + 1, corners[0] + 1, corners[1] + 1, corners[2] + 1, fourth + 1);
    }
    text
}
