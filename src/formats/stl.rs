//! STL: triangles for looking at and for printing. Lengths have no unit there; they are mm.
//!
//! A quadrilateral is cut along its shorter diagonal. The normal of a triangle is that of its corners as they are written, and a
//! triangle without area, in the precision of the file, is left out.

use std::fmt::Write as _;

use super::{
    fault::ExportFault,
    label::{Label, SYSTEM},
    number::real,
    quad_mesh::{Face, QuadMesh},
    text::ascii,
};
use crate::geometry::space::Vector;
use crate::numerics::cancel::Asking;

/// The text form; numbers come back to the last bit.
pub fn ascii_file(mesh: &QuadMesh, label: &Label) -> Result<String, ExportFault> {
    let triangles = triangles(mesh, |x| x);
    let name = ascii(&label.name);
    // Writing to a String cannot fail.
    let mut text = String::new();
    let _ = writeln!(text, "solid {name}");
    let row = |v: &Vector| format!("{} {} {}", real(v.x), real(v.y), real(v.z));
    for (normal, corners) in some(triangles)?.into_iter().asking(500) {
        let _ = writeln!(text, "  facet normal {}\n    outer loop", row(&normal));
        for corner in &corners {
            let _ = writeln!(text, "      vertex {}", row(corner));
        }
        text.push_str("    endloop\n  endfacet\n");
    }
    let _ = writeln!(text, "endsolid {name}");
    Ok(text)
}

/// The binary form: a header of 80 bytes, the number of triangles, and 50 bytes of single precision for each.
pub fn binary_file(mesh: &QuadMesh, label: &Label) -> Result<Vec<u8>, ExportFault> {
    let single = |x: f64| f64::from(x as f32);
    if let Some(index) = mesh.nodes().iter().position(|p| p.iter().any(|x| !single(*x).is_finite())) {
        return Err(ExportFault::NodeRange { index });
    }
    let triangles = some(triangles(mesh, single))?;
    let count = u32::try_from(triangles.len())
        .map_err(|_| ExportFault::TooLong { lines: triangles.len(), most: u32::MAX as usize })?;
    // readers take a file that begins with "solid" for text
    let mut header = format!("{SYSTEM} mm {}", ascii(&label.name)).into_bytes();
    header.resize(80, b' ');
    let mut bytes = header;
    bytes.extend(count.to_le_bytes());
    for (normal, corners) in triangles.iter().asking(100) {
        for vector in std::iter::once(normal).chain(corners) {
            for x in vector.iter() {
                bytes.extend((*x as f32).to_le_bytes());
            }
        }
        bytes.extend([0, 0]);
    }
    Ok(bytes)
}

type Triangle = (Vector, [Vector; 3]);

fn some(triangles: Vec<Triangle>) -> Result<Vec<Triangle>, ExportFault> {
    if triangles.is_empty() { Err(ExportFault::Nothing) } else { Ok(triangles) }
}

/// Unit normal and corners, rounded, of every triangle that has an area.
fn triangles(mesh: &QuadMesh, rounded: impl Fn(f64) -> f64) -> Vec<Triangle> {
    let mut triangles = Vec::with_capacity(2 * mesh.faces().len());
    let mut add = |corners: [usize; 3]| {
        let corners = corners.map(|i| mesh.nodes()[i].map(&rounded));
        let [b, c] = [corners[1] - corners[0], corners[2] - corners[0]];
        // both at most 1 long, so that the product neither overflows nor vanishes
        let longest = b.amax().max(c.amax());
        let normal = (b / longest).cross(&(c / longest));
        if normal.norm() > 0.0 && normal.norm().is_finite() {
            triangles.push((normal / normal.norm(), corners));
        }
    };
    for face in mesh.faces().iter().asking(50) {
        match *face {
            Face::Triangle(corners) => add(corners),
            Face::Quad([a, b, c, d]) => {
                let length = |i: usize, k: usize| (mesh.nodes()[i] - mesh.nodes()[k]).norm();
                let cut = if length(a, c) <= length(b, d) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                cut.into_iter().for_each(&mut add);
            }
        }
    }
    triangles
}
