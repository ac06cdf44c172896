//! STL: triangles for looking at and for printing. Lengths have no unit there; they are mm.
//!
//! A quadrilateral is cut along its shorter diagonal. The normal of a triangle is that of its
//! corners as they are written, and a triangle without area, in the precision of the file, is left
//! out.

use std::{io::Write as _, sync::Arc};

use super::{
    export::{node_range, nothing, too_long},
    label::{Label, SYSTEM},
    number::real,
    pieces::Pieces,
    quad_mesh::{Face, QuadMesh},
    text::ascii,
};
use flankfit_geometry::space::Vector;
use flankfit_numerics::{cancel::Asking, check::Faults};

/// The text form; numbers come back to the last bit.
///
/// ```
/// use flankfit_formats::{Label, QuadMesh, UtcTime, stl};
/// use flankfit_geometry::{space::{Dimension, Vector}, surface::BezierSurface};
///
/// // The unit square in one quadrilateral: two triangles.
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
/// let file = String::from_utf8(stl::ascii_file(mesh.into(), &label)?.whole())?;
/// assert_eq!(file.matches("facet normal").count(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn ascii_file(mesh: Arc<QuadMesh>, label: &Label) -> Result<Pieces, Faults> {
    if !mesh.faces().iter().asking(100).any(|face| triangles(&mesh, face, |x| x).next().is_some()) {
        return Err(nothing());
    }
    let name = ascii(&label.name);
    let row = |v: &Vector| format!("{} {} {}", real(v.x), real(v.y), real(v.z));
    let count = mesh.faces().len();
    let facets = move |i: usize, out: &mut Vec<u8>| {
        for (normal, corners) in triangles(&mesh, &mesh.faces()[i], |x| x) {
            // Writing to a vector cannot fail.
            let _ = writeln!(out, "  facet normal {}\n    outer loop", row(&normal));
            for corner in &corners {
                let _ = writeln!(out, "      vertex {}", row(corner));
            }
            out.extend_from_slice(b"    endloop\n  endfacet\n");
        }
    };
    Ok(Pieces::new().text(format!("solid {name}\n")).lines(count, facets).text(format!("endsolid {name}\n")))
}

/// The binary form: a header of 80 bytes, the number of triangles, and 50 bytes of single precision
/// for each.
pub fn binary_file(mesh: Arc<QuadMesh>, label: &Label) -> Result<Pieces, Faults> {
    let single = |x: f64| f64::from(x as f32);
    if let Some(index) = mesh.nodes().iter().position(|p| p.iter().any(|x| !single(*x).is_finite())) {
        return Err(Faults::one("", node_range(index)));
    }
    let count = |face| triangles(&mesh, face, single).count();
    let triangle_count: usize = mesh.faces().iter().asking(100).map(count).sum();
    if triangle_count == 0 {
        return Err(nothing());
    }
    let written = u32::try_from(triangle_count)
        .map_err(|_| Faults::one("samples", too_long(triangle_count, u32::MAX as usize)))?;
    // readers take a file that begins with "solid" for text
    let mut header = format!("{SYSTEM} mm {}", ascii(&label.name)).into_bytes();
    header.resize(80, b' ');
    header.extend(written.to_le_bytes());
    let faces = mesh.faces().len();
    let records = move |i: usize, out: &mut Vec<u8>| {
        for (normal, corners) in triangles(&mesh, &mesh.faces()[i], single) {
            for vector in std::iter::once(&normal).chain(&corners) {
                for x in vector.iter() {
                    out.extend((*x as f32).to_le_bytes());
                }
            }
            out.extend([0, 0]);
        }
    };
    Ok(Pieces::new().text(header).lines(faces, records))
}

type Triangle = (Vector, [Vector; 3]);

/// Unit normal and corners, rounded, of the triangles of a face that have an area.
fn triangles(mesh: &QuadMesh, face: &Face, rounded: impl Fn(f64) -> f64) -> impl Iterator<Item = Triangle> {
    let node = |i: u32| mesh.nodes()[i as usize];
    let cut = match *face.corners() {
        [a, b, c, d] => {
            let length = |i: u32, k: u32| (node(i) - node(k)).norm();
            if length(a, c) <= length(b, d) {
                [Some([a, b, c]), Some([a, c, d])]
            } else {
                [Some([a, b, d]), Some([b, c, d])]
            }
        }
        [a, b, c] => [Some([a, b, c]), None],
        _ => [None, None],
    };
    let made = cut.map(|corners| {
        let corners = corners?.map(|i| node(i).map(&rounded));
        let [b, c] = [corners[1] - corners[0], corners[2] - corners[0]];
        // both at most 1 long, so that the product neither overflows nor vanishes
        let longest = b.amax().max(c.amax());
        let normal = (b / longest).cross(&(c / longest));
        let there = normal.norm() > 0.0 && normal.norm().is_finite();
        there.then(|| (normal / normal.norm(), corners))
    });
    made.into_iter().flatten()
}
