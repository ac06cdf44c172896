//! VTK legacy files (version 3.0, text): poly data of any number of meshes and lines.
//!
//! Along with the points go their normals. A node without a normal has the zero vector, since the
//! format has no other way to say so. Lengths are mm.

use std::{io::Write as _, sync::Arc};

use super::{
    export::nothing,
    label::{Label, SYSTEM},
    number::real,
    obj::{NamedLine, NamedMesh},
    pieces::Pieces,
    text::ascii,
};
use flankfit_geometry::space::Vector;
use flankfit_numerics::{cancel::Asking, check::Faults};

/// Titles have at most 256 characters, the line's end included.
const TITLE: usize = 255;

/// Meshes and lines together.
pub fn poly_data(meshes: &[NamedMesh], lines: &[NamedLine], label: &Label) -> Result<Pieces, Faults> {
    let nodes = |of: &NamedMesh| of.mesh.nodes().len();
    let count: usize = meshes.iter().map(nodes).chain(lines.iter().map(|line| line.points.len())).sum();
    if count == 0 {
        return Err(nothing());
    }
    let mut file = Pieces::new().text(format!("{}POINTS {count} double\n", head(label, "POLYDATA")));
    for of in meshes {
        let mesh = Arc::clone(&of.mesh);
        file = file.lines(nodes(of), move |i, out| row(out, &mesh.nodes()[i]));
    }
    for NamedLine { points, .. } in lines {
        let points = Arc::clone(points);
        file = file.lines(points.len(), move |i, out| row(out, &points[i]));
    }
    let meshed: usize = meshes.iter().map(nodes).sum();
    // the order that readers of the format expect: lines before polygons
    file = chains(file, meshed, lines);
    file = polygons(file, meshes).text(format!("POINT_DATA {count}\nNORMALS normals double\n"));
    for of in meshes {
        let mesh = Arc::clone(&of.mesh);
        file = file.lines(nodes(of), move |i, out| row(out, &mesh.normal(i).unwrap_or_else(Vector::zeros)));
    }
    Ok(file.lines(count - meshed, |_, out| row(out, &Vector::zeros())))
}

fn chains(mut file: Pieces, mut first: usize, lines: &[NamedLine]) -> Pieces {
    let lengths = || lines.iter().map(|line| line.points.len()).filter(|length| *length > 0);
    if lengths().count() > 0 {
        file =
            file.text(format!("LINES {} {}\n", lengths().count(), lengths().map(|length| length + 1).sum::<usize>()));
    }
    for length in lengths() {
        let begin = first;
        let index = move |i: usize, out: &mut Vec<u8>| {
            // Writing to a vector cannot fail.
            let _ = write!(out, " {}", begin + i);
        };
        file = file.text(length.to_string()).lines(length, index).text("\n");
        first += length;
    }
    file
}

fn polygons(mut file: Pieces, meshes: &[NamedMesh]) -> Pieces {
    let faces = || meshes.iter().flat_map(|of| of.mesh.faces());
    let (count, numbers) = faces().asking(5).fold((0, 0), |(n, sum), face| (n + 1, sum + face.corners().len() + 1));
    if count > 0 {
        file = file.text(format!("POLYGONS {count} {numbers}\n"));
    }
    let mut first = 0;
    for of in meshes {
        let (mesh, begin) = (Arc::clone(&of.mesh), first);
        first += mesh.nodes().len();
        file = file.lines(of.mesh.faces().len(), move |i, out| {
            let corners = mesh.faces()[i].corners();
            let _ = write!(out, "{}", corners.len());
            for corner in corners {
                let _ = write!(out, " {}", begin + *corner as usize);
            }
            out.push(b'\n');
        });
    }
    file
}

fn head(label: &Label, kind: &str) -> String {
    let title = format!("{} ({SYSTEM}, {}, mm)", ascii(&label.name), label.written_at.iso_8601());
    let start = title.len().saturating_sub(TITLE);
    // all ASCII; the end says more than a long name does
    format!("# vtk DataFile Version 3.0\n{}\nASCII\nDATASET {kind}\n", &title[start..])
}

fn row(out: &mut Vec<u8>, v: &Vector) {
    let _ = writeln!(out, "{} {} {}", real(v.x), real(v.y), real(v.z));
}
