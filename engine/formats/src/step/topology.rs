//! A surface over its whole parameter range as the one face of a shell.
//!
//! The loop goes around the parameter rectangle counter-clockwise: along u at the low v, along v at
//! the high u, and back. Where the surface is closed both sides are one edge (a seam), used in both
//! directions. A side that has shrunk to a point is left out.

use super::super::{
    cad::{CadCurve, CadSurface},
    text::step_string,
};
use super::{
    data::{Data, Id},
    list, spline,
};
use flankfit_geometry::space::Vector;

/// An open shell with the surface's face.
pub(super) fn shell(data: &mut Data, name: &str, surface: &CadSurface) -> Id {
    let carrier = spline::surface(data, name, surface);
    let [closed_u, closed_v] = surface.is_closed();
    let mut edges = Edges::default();
    let bottom = edges.add(data, &surface.border(0, false));
    let right = edges.add(data, &surface.border(1, true));
    let top = if closed_v { bottom } else { edges.add(data, &surface.border(0, true)) };
    let left = if closed_u { right } else { edges.add(data, &surface.border(1, false)) };
    let sides = [(bottom, ".T."), (right, ".T."), (top, ".F."), (left, ".F.")];
    let oriented: Vec<Id> = sides
        .into_iter()
        .filter_map(|(edge, sense)| Some(data.add(format!("ORIENTED_EDGE('',*,*,{},{sense})", edge?))))
        .collect();
    let name = step_string(name);
    let bounds = if oriented.is_empty() {
        // the whole surface has shrunk to a point
        let vertex = edges.vertex(data, &surface.points[0]);
        data.add(format!("VERTEX_LOOP('',{vertex})"))
    } else {
        data.add(format!("EDGE_LOOP('',{})", list(&oriented)))
    };
    let bound = data.add(format!("FACE_OUTER_BOUND('',{bounds},.T.)"));
    let face = data.add(format!("ADVANCED_FACE({name},({bound}),{carrier},.T.)"));
    data.add(format!("OPEN_SHELL({name},({face}))"))
}

/// Edges of one face, and its vertices, each of which is one instance.
#[derive(Default)]
struct Edges {
    vertices: Vec<(Vector, Id)>,
}

impl Edges {
    /// The edge along a border, unless that has no length.
    fn add(&mut self, data: &mut Data, border: &CadCurve) -> Option<Id> {
        let (first, last) = (border.points.first()?, border.points.last()?);
        if border.is_point() {
            return None;
        }
        let (from, to) = (self.vertex(data, first), self.vertex(data, last));
        let curve = spline::curve(data, "", border);
        Some(data.add(format!("EDGE_CURVE('',{from},{to},{curve},.T.)")))
    }

    fn vertex(&mut self, data: &mut Data, place: &Vector) -> Id {
        if let Some((_, id)) = self.vertices.iter().find(|(known, _)| known == place) {
            return *id;
        }
        let point = spline::point(data, place);
        let id = data.add(format!("VERTEX_POINT('',{point})"));
        self.vertices.push((*place, id));
        id
    }
}
