//! Edges of cells, and segments between them in rows.

use std::collections::BTreeMap;

use super::cells::Place;

/// An edge of cells from a corner along u (0) or v (1).
pub(super) type Edge = (Place, usize);

/// The edges around a cell.
pub(super) fn edges((i, j): Place) -> [Edge; 4] {
    [((i, j), 0), ((i, j), 1), ((i, j + 1), 0), ((i + 1, j), 1)]
}

/// The corners at both ends of an edge.
pub(super) fn ends(((i, j), axis): Edge) -> [Place; 2] {
    [(i, j), if axis == 0 { (i + 1, j) } else { (i, j + 1) }]
}

/// The cells on both sides of an edge; of a border one may lie outside.
pub(super) fn cells_of(((i, j), axis): Edge) -> [Option<Place>; 2] {
    let before = if axis == 0 { j.checked_sub(1).map(|j| (i, j)) } else { i.checked_sub(1).map(|i| (i, j)) };
    [Some((i, j)), before]
}

/// Segments that share an edge, in a row; and whether the row is closed.
pub(super) fn rows(segments: &[[Edge; 2]]) -> Vec<(Vec<Edge>, bool)> {
    let mut at: BTreeMap<Edge, Vec<usize>> = BTreeMap::new();
    for (k, segment) in segments.iter().enumerate() {
        for edge in segment {
            at.entry(*edge).or_default().push(k);
        }
    }
    let mut used = vec![false; segments.len()];
    let mut walk = |from: Edge| {
        let mut row = vec![from];
        let mut here = from;
        while let Some(k) = at.get(&here).and_then(|next| next.iter().copied().find(|k| !used[*k])) {
            used[k] = true;
            let [a, b] = segments[k];
            here = if a == here { b } else { a };
            row.push(here);
        }
        row
    };
    let loose: Vec<Edge> = at.iter().filter(|(_, segments)| segments.len() == 1).map(|(edge, _)| *edge).collect();
    let mut rows: Vec<(Vec<Edge>, bool)> = Vec::new();
    for edge in loose {
        let row = walk(edge);
        if row.len() > 1 {
            rows.push((row, false));
        }
    }
    // what is left runs in circles
    for segment in segments {
        let mut row = walk(segment[0]);
        if row.len() > 2 {
            row.pop();
            rows.push((row, true));
        }
    }
    rows
}
