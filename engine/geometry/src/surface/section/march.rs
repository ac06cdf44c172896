//! From cells to chains of places: where the section passes the edges of the cells, one line
//! through each.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    borders::on_side,
    boxes::{Block, boxes, meets, within},
    cells::{Knot, Place, Rectangle, SearchResult},
    chain::{Chain, Pieces},
    field::{Bending, Field, Kind},
    rows::{Edge, cells_of, edges, ends, rows},
};
use flankfit_numerics::cancel::checkpoint;

/// Parts that are looked at by themselves go so deep at most.
const DEEPEST: u32 = 4;

/// A place where branches cross, and the cells about it.
struct Crossing {
    at: [f64; 2],
    cells: BTreeSet<Place>,
}

/// The section within `rectangle`, with the parts about places without slope.
pub(super) fn pieces(rectangle: &Rectangle<'_>, found: SearchResult, sides: &[(usize, usize)], all: &mut Pieces) {
    all.coincident |= found.coincident;
    let level = found.level;
    let (mut settled, mut inner): (Vec<Knot>, Vec<Knot>) =
        found.knots.into_iter().partition(|knot| is_settled(rectangle, level, knot));
    // a part that reaches a knot takes it in
    let parts = loop {
        let parts = boxes(rectangle, level, &inner);
        let (taken, apart): (Vec<Knot>, Vec<Knot>) = settled
            .into_iter()
            .partition(|knot| knot.cells.iter().any(|cell| parts.iter().any(|part| meets(part, cell))));
        settled = apart;
        if taken.is_empty() {
            break parts;
        }
        inner.extend(taken);
    };
    let mut simple = found.simple;
    for part in parts {
        simple.retain(|cell| !within(&part, cell));
        inside(rectangle, level, part, sides, all);
    }
    let mut crossings = Vec::new();
    for knot in settled {
        let [(at, bending), ..] = knot.places[..] else { continue };
        let pole = rectangle.field.at(at).is_pole();
        match bending {
            Bending::Trough => touching(rectangle, level, (&knot.cells, at), sides, all),
            Bending::Bowl if pole => {}
            Bending::Bowl => all.contacts.push(at),
            Bending::Saddle => {
                if !pole {
                    all.branches.push(at);
                }
                crossings.push(Crossing { at, cells: knot.cells });
            }
        }
    }
    lines(rectangle, level, &simple, (&crossings, sides), all);
}

/// Whether one place without slope explains a knot: none or four lines run from it, but where it
/// lies on a side of the smooth rectangle.
fn is_settled(rectangle: &Rectangle<'_>, level: u32, knot: &Knot) -> bool {
    let ([(at, bending)], true) = (&knot.places[..], knot.explained) else { return false };
    let wanted = match bending {
        Bending::Trough => return true,
        Bending::Bowl => 0,
        Bending::Saddle => 4,
    };
    rectangle.field.at(*at).is_pole()
        || !is_inside(rectangle, *at)
        || lines_around(rectangle, level, &knot.cells) == wanted
}

/// Whether a place lies within the smooth rectangle, not on a side of it.
fn is_inside(rectangle: &Rectangle<'_>, at: [f64; 2]) -> bool {
    (0..2).all(|k| {
        let [low, high] = rectangle.field.smooth[k];
        (at[k] - low).min(high - at[k]) > 1e-6 * (high - low)
    })
}

/// On how many edges between these cells and others the height changes its sign.
fn lines_around(rectangle: &Rectangle<'_>, level: u32, cells: &BTreeSet<Place>) -> usize {
    let above = |corner: Place| rectangle.field.height(rectangle.corner(level, corner)) >= -rectangle.rounding;
    let outer = |edge: &Edge| cells_of(*edge).into_iter().flatten().filter(|cell| cells.contains(cell)).count() == 1;
    let around = cells.iter().flat_map(|cell| edges(*cell)).filter(outer);
    around.filter(|edge| ends(*edge).map(above) == [true, false] || ends(*edge).map(above) == [false, true]).count()
}

/// Looks at a part by itself.
fn inside(rectangle: &Rectangle<'_>, level: u32, part: Block, sides: &[(usize, usize)], all: &mut Pieces) {
    let (heights, range) = rectangle.part(level, [part[0], (part[1].0 + 1, part[1].1 + 1)]);
    if rectangle.depth == DEEPEST || rectangle.left.get() == 0 {
        all.unresolved.push(in_plane(rectangle.field, range));
        return;
    }
    let own = Rectangle { range, heights, depth: rectangle.depth + 1, ..*rectangle };
    let found = own.search();
    pieces(&own, found, sides, all);
}

/// The place of a rectangle that is nearest to the plane, of those that Newton's method leads to
/// from its middle and its corners.
fn in_plane(field: &Field<'_>, [u, v]: [[f64; 2]; 2]) -> [f64; 2] {
    let middle = [0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1])];
    let starts = [middle, [u[0], v[0]], [u[0], v[1]], [u[1], v[0]], [u[1], v[1]]];
    let inside = |at: [f64; 2]| [at[0].clamp(u[0], u[1]), at[1].clamp(v[0], v[1])];
    let found = starts.into_iter().flat_map(|at| [inside(field.onto(at, Kind::Across)), at]);
    let height = |at: &[f64; 2]| field.height(*at).abs();
    found.min_by(|a, b| height(a).total_cmp(&height(b))).unwrap_or(middle)
}

/// Sign changes of the height on the edges of simple cells, joined cell by cell.
fn lines(
    rectangle: &Rectangle<'_>,
    level: u32,
    cells: &BTreeSet<Place>,
    (crossings, sides): (&[Crossing], &[(usize, usize)]),
    all: &mut Pieces,
) {
    let field = rectangle.field;
    let mut above: BTreeMap<Place, bool> = BTreeMap::new();
    let mut sign = |corner: Place| {
        *above.entry(corner).or_insert_with(|| field.height(rectangle.corner(level, corner)) >= -rectangle.rounding)
    };
    let mut segments: Vec<[Edge; 2]> = Vec::new();
    for cell in cells {
        checkpoint();
        let crossed: Vec<Edge> = edges(*cell)
            .into_iter()
            .filter(|edge| {
                let [a, b] = ends(*edge);
                sign(a) != sign(b)
            })
            .collect();
        if let [a, b] = crossed[..] {
            segments.push([a, b]);
        }
    }
    let place = |edge: Edge| {
        let [a, b] = ends(edge).map(|corner| rectangle.corner(level, corner));
        field.crossing(a, b, None)
    };
    // out of a knot straight over a side of the rectangle, but one that the knot lies on
    let last = 1_u32 << level;
    let leaves = |((i, j), axis): &Edge, at: &[f64; 2]| {
        let (k, across) = if *axis == 0 { (*j, 1) } else { (*i, 0) };
        let [low, high] = rectangle.range[across];
        let side = if k == 0 { low } else { high };
        (k == 0 || k == last) && (at[across] - side).abs() > 1e-6 * (high - low)
    };
    for Crossing { at, cells } in crossings {
        for edge in cells.iter().flat_map(|cell| edges(*cell)).filter(|edge| leaves(edge, at)) {
            let [a, b] = ends(edge);
            if sign(a) != sign(b) {
                all.chains.push(Chain { places: vec![(*at, Kind::End), (place(edge), Kind::Across)], closed: false });
            }
        }
    }
    for (edges, closed) in rows(&segments) {
        let mut places: Vec<_> = edges.iter().map(|edge| (place(*edge), Kind::Across)).collect();
        // sides that lie in the plane are taken as a whole
        if on_side(&field.smooth, sides, places.iter().map(|(at, _)| at)) {
            continue;
        }
        // where rounding alone changes the sign there is no line
        if let Some((at, _)) = places.iter().find(|(at, _)| field.height(*at).abs() > rectangle.rounding) {
            all.unresolved.push(*at);
            continue;
        }
        if !closed {
            let meets = |edge: &Edge| {
                let beside =
                    |cells: &BTreeSet<Place>| cells_of(*edge).into_iter().flatten().any(|cell| cells.contains(&cell));
                crossings.iter().find(|knot| beside(&knot.cells)).map(|knot| (knot.at, Kind::End))
            };
            let (first, last) = (edges.first().and_then(meets), edges.last().and_then(meets));
            places.extend(last);
            if let Some(first) = first {
                places.insert(0, first);
            }
        }
        all.chains.push(Chain { places, closed });
    }
}

/// The line along which the plane touches: on edges that it crosses the slope along them changes
/// its sign.
fn touching(
    rectangle: &Rectangle<'_>,
    level: u32,
    (cells, at): (&BTreeSet<Place>, [f64; 2]),
    sides: &[(usize, usize)],
    all: &mut Pieces,
) {
    let field: &Field<'_> = rectangle.field;
    let mut slopes: BTreeMap<Place, [bool; 2]> = BTreeMap::new();
    let mut places: BTreeMap<Edge, Option<[f64; 2]>> = BTreeMap::new();
    let mut segments = Vec::new();
    for cell in cells {
        checkpoint();
        let crossed: Vec<Edge> = edges(*cell)
            .into_iter()
            .filter(|edge| {
                let found = places.entry(*edge).or_insert_with(|| {
                    let [a, b] = ends(*edge);
                    let mut sign = |corner: Place| {
                        slopes.entry(corner).or_insert_with(|| {
                            field.at(rectangle.corner(level, corner)).slope.map(|slope| slope >= 0.0)
                        })[edge.1]
                    };
                    if sign(a) == sign(b) {
                        return None;
                    }
                    let [a, b] = [a, b].map(|corner| rectangle.corner(level, corner));
                    let at = field.crossing(a, b, Some(edge.1));
                    (field.height(at).abs() <= 10.0 * rectangle.contact).then_some(at)
                });
                found.is_some()
            })
            .collect();
        if let [a, b] = crossed[..] {
            segments.push([a, b]);
        }
    }
    let rows = rows(&segments);
    if rows.is_empty() {
        // at a pole the whole line is one place
        if field.at(at).is_pole() { &mut all.contacts } else { &mut all.unresolved }.push(at);
    }
    for (edges, closed) in rows {
        let found: Vec<[f64; 2]> = edges.iter().filter_map(|edge| places[edge]).collect();
        // sides that lie in the plane are taken as a whole
        if on_side(&field.smooth, sides, found.iter()) {
            continue;
        }
        let places = found.into_iter().map(|at| (at, Kind::Touching)).collect();
        all.chains.push(Chain { places, closed });
    }
}
