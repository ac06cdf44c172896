//! Common first part of the input of finite-element programs: a title, then numbered nodes.

use flankfit_numerics::check::Faults;
use std::{io::Write as _, sync::Arc};

use super::super::{
    export::nothing, label::Label, number::real_within, pieces::Pieces, quad_mesh::QuadMesh, text::ascii,
};

/// Abaqus takes a number from so many columns, and ADINA a number with three coordinates from a
/// line of 80; what would need more is rounded, to 12 digits at worst.
const WIDTH: usize = 20;

/// The name in at most so many ASCII characters, and when it was written; a mesh without elements
/// is refused.
pub(super) fn title(mesh: &QuadMesh, label: &Label, most: usize) -> Result<(String, String), Faults> {
    if mesh.faces().is_empty() {
        return Err(nothing());
    }
    Ok((ascii(&label.name).chars().take(most).collect(), label.written_at.iso_8601()))
}

/// A line for every node: its number, counted from 1, and its coordinates.
pub(super) fn node_lines(file: Pieces, mesh: Arc<QuadMesh>, separator: &'static str) -> Pieces {
    file.lines(mesh.nodes().len(), move |i, out| {
        let p = mesh.nodes()[i];
        let [x, y, z] = [p.x, p.y, p.z].map(|x| real_within(x, WIDTH));
        // Writing to a vector cannot fail.
        let _ = writeln!(out, "{}{separator}{x}{separator}{y}{separator}{z}", i + 1);
    })
}
