//! Wavefront OBJ: faces and lines for looking at. Lengths have no unit there; they are mm.

use std::{io::Write as _, sync::Arc};

use super::{
    export::nothing,
    label::{Label, SYSTEM},
    number::real,
    pieces::Pieces,
    quad_mesh::QuadMesh,
    text::ascii,
};
use flankfit_geometry::space::Vector;
use flankfit_numerics::{cancel::Asking, check::Faults};

/// A mesh and its name in the file.
#[derive(Clone, Debug)]
pub struct NamedMesh<'a> {
    /// Name of the entity in the file.
    pub name: &'a str,
    /// The mesh; shared, for it may be large.
    pub mesh: Arc<QuadMesh>,
}

/// A chain of points and its name in the file.
#[derive(Clone, Debug)]
pub struct NamedLine<'a> {
    /// Name of the entity in the file.
    pub name: &'a str,
    /// The points in order; mm.
    pub points: Arc<[Vector]>,
}

/// Objects of faces with normals, and objects of one line each. A face with a node that has no
/// normal is written without.
///
/// ```
/// use flankfit_formats::{Label, NamedMesh, QuadMesh, UtcTime, obj};
/// use flankfit_geometry::{space::{Dimension, Vector}, surface::BezierSurface};
///
/// // The unit square in 2 × 3 quadrilaterals has 3 × 4 vertices.
/// let square = [[0.0, 1.0]; 2];
/// let heights = vec![Vector::zeros(); 4];
/// let flat = BezierSurface::new([2, 2], square, Dimension::Graph, heights, None)?;
/// let mesh = QuadMesh::of_surfaces(&[&flat], [2, 3], 0.0, true)?;
/// let label = Label {
///     name: "flat".into(),
///     author: String::new(),
///     organization: String::new(),
///     written_at: UtcTime::epoch(),
/// };
/// let file = obj::write(&[NamedMesh { name: "flat", mesh: mesh.into() }], &[], &label)?;
/// let file = String::from_utf8(file.whole())?;
/// let count = |head: &str| file.lines().filter(|line| line.starts_with(head)).count();
/// assert_eq!((count("v "), count("f ")), (12, 6));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write(meshes: &[NamedMesh], lines: &[NamedLine], label: &Label) -> Result<Pieces, Faults> {
    if meshes.is_empty() && lines.is_empty() {
        return Err(nothing());
    }
    let (title, written) = (ascii(&label.name), label.written_at.iso_8601());
    let mut file = Pieces::new().text(format!("# {title}\n# {SYSTEM}, {written}, lengths in mm\n"));
    let (mut places, mut normals) = (1, 1);
    for NamedMesh { name, mesh } in meshes {
        let numbers = Numbers::of(mesh, normals);
        normals += numbers.count;
        let count = mesh.nodes().len();
        let [of_nodes, of_normals, of_faces] = [(); 3].map(|()| Arc::clone(mesh));
        file = file
            .text(format!("o {}\n", object(name)))
            .lines(count, move |i, out| vector(out, "v", &of_nodes.nodes()[i]))
            .lines(count, move |i, out| {
                if let Some(normal) = of_normals.normal(i) {
                    vector(out, "vn", &normal);
                }
            })
            .lines(mesh.faces().len(), move |i, out| face(out, of_faces.faces()[i].corners(), places, &numbers));
        places += count;
    }
    for NamedLine { name, points } in lines {
        let (first, count, points) = (places, points.len(), Arc::clone(points));
        file = file
            .text(format!("o {}\n", object(name)))
            .lines(count, move |i, out| vector(out, "v", &points[i]))
            .text("l")
            .lines(count, move |i, out| {
                // Writing to a vector cannot fail.
                let _ = write!(out, " {}", first + i);
            })
            .text("\n");
        places += count;
    }
    Ok(file)
}

/// Number of each node's normal in the file.
struct Numbers {
    first: usize,
    count: usize,
    /// Number of the normal of each node from `first` on; empty if every node has a normal.
    some: Vec<Option<std::num::NonZeroU32>>,
}

impl Numbers {
    fn of(mesh: &QuadMesh, first: usize) -> Self {
        let count = mesh.normals().asking(10).flatten().count();
        let mut next = 0;
        let some = match count == mesh.nodes().len() {
            true => Vec::new(),
            false => mesh
                .normals()
                .asking(20)
                .map(|normal| {
                    next += u32::from(normal.is_some());
                    std::num::NonZeroU32::new(next).filter(|_| normal.is_some())
                })
                .collect(),
        };
        Numbers { first, count, some }
    }

    fn get(&self, node: usize) -> Option<usize> {
        match self.some.get(node) {
            Some(number) => number.map(|number| self.first + number.get() as usize - 1),
            None => Some(self.first + node),
        }
    }
}

fn face(out: &mut Vec<u8>, corners: &[u32], places: usize, numbers: &Numbers) {
    let smooth = corners.iter().all(|i| numbers.get(*i as usize).is_some());
    out.push(b'f');
    for i in corners {
        // Writing to a vector cannot fail.
        let _ = write!(out, " {}", places + *i as usize);
        if let (true, Some(normal)) = (smooth, numbers.get(*i as usize)) {
            let _ = write!(out, "//{normal}");
        }
    }
    out.push(b'\n');
}

fn vector(out: &mut Vec<u8>, keyword: &str, v: &Vector) {
    let _ = writeln!(out, "{keyword} {} {} {}", real(v.x), real(v.y), real(v.z));
}

/// Names are single words.
fn object(name: &str) -> String {
    let word = ascii(name).replace(' ', "_");
    if word.is_empty() { "unnamed".to_owned() } else { word }
}
