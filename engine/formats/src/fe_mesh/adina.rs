//! ADINA-IN commands: nodal coordinates, and a group of shell elements of four nodes.

use flankfit_numerics::check::Faults;
use std::{io::Write as _, sync::Arc};

use super::{
    super::{
        label::{Label, SYSTEM},
        pieces::Pieces,
        quad_mesh::QuadMesh,
    },
    coordinates::{node_lines, title},
};

/// Commands that add nodes and elements to a model; a triangle repeats its third node. Material,
/// thickness and loads are the user's.
pub fn adina(mesh: Arc<QuadMesh>, label: &Label) -> Result<Pieces, Faults> {
    let (name, written) = title(&mesh, label, 76)?;
    let head = format!("* {name}\n* {SYSTEM}, {written}, lengths in mm\n*\nCOORDINATES NODE SYSTEM=0\n@CLEAR\n");
    let faces = mesh.faces().len();
    let file = node_lines(Pieces::new().text(head), Arc::clone(&mesh), " ")
        .text("@\n*\nEGROUP SHELL NAME=1\n*\nENODES SUBSTRUC=0 GROUP=1 NNODES=4\n@CLEAR\n")
        .lines(faces, move |i, out| {
            let [a, b, c, d] = mesh.faces()[i].four().map(|node| node + 1);
            let _ = writeln!(out, "{} {a} {b} {c} {d}", i + 1);
        });
    Ok(file.text("@\n"))
}
