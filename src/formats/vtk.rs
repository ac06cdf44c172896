//! VTK legacy files (version 3.0, text): a structured grid for one surface, poly data for any number of meshes and lines.
//!
//! Along with the points go their normals, mean and Gaussian curvature if there are at every node, and whatever fields the caller
//! has. A node without a normal has the zero vector, since the format has no other way to say so. Lengths are mm.

use std::fmt::Write as _;

use super::{
    fault::ExportFault,
    label::{Label, SYSTEM},
    number::real,
    obj::{NamedLine, NamedMesh},
    sampling::SurfaceSample,
    text::ascii,
};
use crate::geometry::space::Vector;
use crate::numerics::cancel::Asking;

/// A number for each node of a sample, in the order of its nodes.
#[derive(Clone, Copy, Debug)]
pub struct PointField<'a> {
    pub name: &'a str,
    pub values: &'a [f64],
}

/// Titles have at most 256 characters, the line's end included.
const TITLE: usize = 255;

/// One surface with its grid; u is the first index of the structured grid.
pub fn structured_grid(sample: &SurfaceSample, fields: &[PointField], label: &Label) -> Result<String, ExportFault> {
    let [m, n] = sample.size();
    for PointField { name, values } in fields {
        let name = || (*name).to_owned();
        if values.len() != m * n {
            return Err(ExportFault::FieldLength { name: name(), given: values.len(), wanted: m * n });
        }
        if let Some(index) = values.iter().position(|x| !x.is_finite()) {
            return Err(ExportFault::FieldValue { name: name(), index });
        }
    }
    let u_fastest = || (0..n).flat_map(|j| (0..m).map(move |i| i * n + j));
    let mut text = head(label, "STRUCTURED_GRID");
    // Writing to a String cannot fail.
    let _ = writeln!(text, "DIMENSIONS {m} {n} 1\nPOINTS {} double", m * n);
    rows(&mut text, u_fastest().map(|i| sample.nodes()[i]));
    let _ = writeln!(text, "POINT_DATA {}\nNORMALS normals double", m * n);
    rows(&mut text, u_fastest().map(|i| sample.normals()[i].unwrap_or_else(Vector::zeros)));
    let mut scalars = |name: &str, value: &dyn Fn(usize) -> f64| {
        let _ = writeln!(text, "SCALARS {} double 1\nLOOKUP_TABLE default", word(name));
        for i in u_fastest().asking(200) {
            let _ = writeln!(text, "{}", real(value(i)));
        }
    };
    let curvatures: Option<Vec<[f64; 2]>> = sample.curvatures().iter().copied().collect();
    for (k, name) in ["mean_curvature", "gaussian_curvature"].into_iter().enumerate() {
        if let Some(curvatures) = &curvatures {
            scalars(name, &|i| curvatures[i][k]);
        }
    }
    for PointField { name, values } in fields {
        scalars(name, &|i| values[i]);
    }
    Ok(text)
}

/// Meshes and lines together.
pub fn poly_data(meshes: &[NamedMesh], lines: &[NamedLine], label: &Label) -> Result<String, ExportFault> {
    let meshed = || meshes.iter().flat_map(|m| m.mesh.nodes());
    let drawn = || lines.iter().flat_map(|l| l.points);
    let count = meshed().count() + drawn().count();
    if count == 0 {
        return Err(ExportFault::Nothing);
    }
    let mut text = head(label, "POLYDATA");
    let _ = writeln!(text, "POINTS {count} double");
    rows(&mut text, meshed().chain(drawn()).copied());
    let mut first = 0;
    let mut faces = Vec::new();
    for NamedMesh { mesh, .. } in meshes {
        faces.extend(mesh.faces().iter().map(|f| f.corners().iter().map(|i| first + i).collect::<Vec<_>>()));
        first += mesh.nodes().len();
    }
    let mut chains = Vec::new();
    for NamedLine { points, .. } in lines.iter().filter(|line| !line.points.is_empty()) {
        chains.push((first..first + points.len()).collect::<Vec<_>>());
        first += points.len();
    }
    // the order that readers of the format expect: lines before polygons
    for (keyword, cells) in [("LINES", chains), ("POLYGONS", faces)] {
        if cells.is_empty() {
            continue;
        }
        let _ = writeln!(text, "{keyword} {} {}", cells.len(), cells.iter().map(|c| c.len() + 1).sum::<usize>());
        for cell in cells.into_iter().asking(200) {
            let _ = write!(text, "{}", cell.len());
            for i in cell {
                let _ = write!(text, " {i}");
            }
            text.push('\n');
        }
    }
    let _ = writeln!(text, "POINT_DATA {count}\nNORMALS normals double");
    let normals = meshes.iter().flat_map(|m| m.mesh.normals()).map(|n| n.unwrap_or_else(Vector::zeros));
    rows(&mut text, normals.chain(drawn().map(|_| Vector::zeros())));
    Ok(text)
}

fn head(label: &Label, kind: &str) -> String {
    let title = format!("{} ({SYSTEM}, {}, mm)", ascii(&label.name), label.written_at.iso_8601());
    let start = title.len().saturating_sub(TITLE);
    // all ASCII; the end says more than a long name does
    format!("# vtk DataFile Version 3.0\n{}\nASCII\nDATASET {kind}\n", &title[start..])
}

fn rows(text: &mut String, vectors: impl Iterator<Item = Vector>) {
    for v in vectors.into_iter().asking(300) {
        let _ = writeln!(text, "{} {} {}", real(v.x), real(v.y), real(v.z));
    }
}

/// Names of fields are single words.
fn word(name: &str) -> String {
    let word = ascii(name).replace(' ', "_");
    if word.is_empty() { "field".to_owned() } else { word }
}
