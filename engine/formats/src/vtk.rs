//! VTK legacy files (version 3.0, text): a structured grid for one surface, poly data for any
//! number of meshes and lines.
//!
//! Along with the points go their normals, mean and Gaussian curvature if there are at every node,
//! and whatever fields the caller has. A node without a normal has the zero vector, since the
//! format has no other way to say so. Lengths are mm.

use std::{io::Write as _, sync::Arc};

use super::{
    export::nothing,
    label::{Label, SYSTEM},
    number::real,
    obj::{NamedLine, NamedMesh},
    pieces::Pieces,
    sampling::SurfaceSample,
    text::ascii,
};
use flankfit_geometry::space::Vector;
use flankfit_numerics::{cancel::Asking, check::Faults};

/// A number for each node of a sample, in the order of its nodes.
#[derive(Clone, Copy, Debug)]
pub struct PointField<'a> {
    /// Name of the field in the file.
    pub name: &'a str,
    /// One number for each node.
    pub values: &'a [f64],
}

/// Titles have at most 256 characters, the line's end included.
const TITLE: usize = 255;

/// One surface with its grid; u is the first index of the structured grid.
///
/// ```
/// use flankfit_formats::{Label, SurfaceSample, UtcTime, vtk};
/// use flankfit_geometry::{space::{Dimension, Vector}, surface::BezierSurface};
///
/// let square = [[0.0, 1.0]; 2];
/// let heights = vec![Vector::zeros(); 4];
/// let flat = BezierSurface::new([2, 2], square, Dimension::Graph, heights, None)?;
/// let sample = SurfaceSample::new(&flat, &[0.0, 0.5, 1.0], &[0.0, 1.0])?;
/// let label = Label {
///     name: "flat".into(),
///     author: String::new(),
///     organization: String::new(),
///     written_at: UtcTime::epoch(),
/// };
/// let file = String::from_utf8(vtk::structured_grid(&sample, &[], &label)?.whole())?;
/// assert!(file.contains("STRUCTURED_GRID") && file.contains("POINTS 6 double"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn structured_grid(sample: &SurfaceSample, fields: &[PointField], label: &Label) -> Result<Pieces, Faults> {
    let [m, n] = sample.size();
    for PointField { name, values } in fields {
        let (given, wanted) = (values.len(), m * n);
        if given != wanted {
            let message = format_args!("the field {name} has {given} values for {wanted} nodes");
            return Err(Faults::one("fields", message));
        }
        if let Some(index) = values.iter().position(|x| !x.is_finite()) {
            return Err(Faults::one("fields", format_args!("value {index} of the field {name} is not finite")));
        }
    }
    let u_fastest = || (0..n).flat_map(|j| (0..m).map(move |i| i * n + j));
    let mut text = head(label, "STRUCTURED_GRID").into_bytes();
    // Writing to a vector cannot fail.
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
    Ok(Pieces::new().text(text))
}

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

fn rows(text: &mut Vec<u8>, vectors: impl Iterator<Item = Vector>) {
    for v in vectors.asking(300) {
        row(text, &v);
    }
}

fn row(out: &mut Vec<u8>, v: &Vector) {
    let _ = writeln!(out, "{} {} {}", real(v.x), real(v.y), real(v.z));
}

/// Names of fields are single words.
fn word(name: &str) -> String {
    let word = ascii(name).replace(' ', "_");
    if word.is_empty() { "field".to_owned() } else { word }
}
