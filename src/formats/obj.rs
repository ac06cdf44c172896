//! Wavefront OBJ: faces and lines for looking at. Lengths have no unit there; they are mm.

use std::fmt::Write as _;

use super::{
    fault::ExportFault,
    label::{Label, SYSTEM},
    number::real,
    quad_mesh::QuadMesh,
    text::ascii,
};
use crate::geometry::space::Vector;
use crate::numerics::cancel::Asking;

/// A mesh and its name in the file.
#[derive(Clone, Copy, Debug)]
pub struct NamedMesh<'a> {
    pub name: &'a str,
    pub mesh: &'a QuadMesh,
}

/// A chain of points and its name in the file.
#[derive(Clone, Copy, Debug)]
pub struct NamedLine<'a> {
    pub name: &'a str,
    pub points: &'a [Vector],
}

/// Objects of faces with normals, and objects of one line each. A face with a node that has no normal is written without.
pub fn write(meshes: &[NamedMesh], lines: &[NamedLine], label: &Label) -> Result<String, ExportFault> {
    if meshes.is_empty() && lines.is_empty() {
        return Err(ExportFault::Nothing);
    }
    // Writing to a String cannot fail.
    let mut text = String::new();
    let _ = writeln!(text, "# {}\n# {SYSTEM}, {}, lengths in mm", ascii(&label.name), label.written_at.iso_8601());
    let (mut places, mut normals) = (1, 1);
    for NamedMesh { name, mesh } in meshes {
        let _ = writeln!(text, "o {}", object(name));
        vectors(&mut text, "v", mesh.nodes().iter());
        vectors(&mut text, "vn", mesh.normals().iter().flatten());
        let mut numbers = Vec::with_capacity(mesh.normals().len());
        for normal in mesh.normals().iter().asking(200) {
            numbers.push(normal.map(|_| normals));
            normals += usize::from(normal.is_some());
        }
        for face in mesh.faces().iter().asking(200) {
            let smooth = face.corners().iter().all(|i| numbers[*i].is_some());
            text.push('f');
            for i in face.corners() {
                let _ = write!(text, " {}", places + i);
                if let (true, Some(normal)) = (smooth, numbers[*i]) {
                    let _ = write!(text, "//{normal}");
                }
            }
            text.push('\n');
        }
        places += mesh.nodes().len();
    }
    for NamedLine { name, points } in lines {
        let _ = writeln!(text, "o {}", object(name));
        vectors(&mut text, "v", points.iter());
        text.push('l');
        for i in (0..points.len()).asking(50) {
            let _ = write!(text, " {}", places + i);
        }
        text.push('\n');
        places += points.len();
    }
    Ok(text)
}

fn vectors<'a>(text: &mut String, keyword: &str, vectors: impl Iterator<Item = &'a Vector>) {
    for v in vectors.into_iter().asking(300) {
        let _ = writeln!(text, "{keyword} {} {} {}", real(v.x), real(v.y), real(v.z));
    }
}

/// Names are single words.
fn object(name: &str) -> String {
    let word = ascii(name).replace(' ', "_");
    if word.is_empty() { "unnamed".to_owned() } else { word }
}
