//! Rectangles of cells that are looked at by themselves.

use super::cells::{Knot, Place, Rectangle};

/// The first and the last cell.
pub(super) type Block = [Place; 2];

/// Rectangles around knots, grown until none meets another and the section passes each edge of
/// cells around them at most once: so that lines within and without end at the same places.
pub(super) fn boxes(rectangle: &Rectangle<'_>, level: u32, knots: &[Knot]) -> Vec<Block> {
    let around = |knot: &Knot| {
        let corner = |of: fn(u32, u32) -> u32, start: u32| {
            knot.cells.iter().fold((start, start), |to, cell| (of(to.0, cell.0), of(to.1, cell.1)))
        };
        [corner(u32::min, u32::MAX), corner(u32::max, 0)]
    };
    let mut all = joined(knots.iter().map(around).collect());
    loop {
        let mut grown = false;
        for own in &mut all {
            grown |= grow(rectangle, level, own);
        }
        if !grown {
            return all;
        }
        all = joined(all);
    }
}

/// Joins rectangles that meet.
fn joined(boxes: Vec<Block>) -> Vec<Block> {
    let meets = |a: &Block, b: &Block| {
        a[0].0 <= b[1].0 + 1 && b[0].0 <= a[1].0 + 1 && a[0].1 <= b[1].1 + 1 && b[0].1 <= a[1].1 + 1
    };
    let mut all: Vec<Block> = Vec::new();
    for mut own in boxes {
        while let Some(k) = all.iter().position(|other| meets(other, &own)) {
            let other = all.swap_remove(k);
            own = [
                (own[0].0.min(other[0].0), own[0].1.min(other[0].1)),
                (own[1].0.max(other[1].0), own[1].1.max(other[1].1)),
            ];
        }
        all.push(own);
    }
    all
}

/// Moves those sides outwards by a cell that the section passes twice in one cell.
fn grow(rectangle: &Rectangle<'_>, level: u32, own: &mut Block) -> bool {
    let last = (1_u32 << level) - 1;
    let [from, to] = *own;
    let twice = |(axis, end): (usize, usize)| {
        let cells = if axis == 0 { from.1..=to.1 } else { from.0..=to.0 };
        cells.into_iter().any(|k| {
            let side = [from, to][end];
            let cell = if axis == 0 { (side.0, k) } else { (k, side.1) };
            let (heights, [u, v]) = rectangle.part(level, [cell, (cell.0 + 1, cell.1 + 1)]);
            !heights.passes_once(rectangle.field, [[u[0], v[0]], [u[1], v[1]]], (axis, end), rectangle.contact)
        })
    };
    let grown = [
        from.0 > 0 && twice((0, 0)),
        to.0 < last && twice((0, 1)),
        from.1 > 0 && twice((1, 0)),
        to.1 < last && twice((1, 1)),
    ];
    let [low_u, high_u, low_v, high_v] = grown.map(u32::from);
    *own = [(from.0 - low_u, from.1 - low_v), (to.0 + high_u, to.1 + high_v)];
    grown.contains(&true)
}

pub(super) fn within(part: &Block, cell: &Place) -> bool {
    (part[0].0..=part[1].0).contains(&cell.0) && (part[0].1..=part[1].1).contains(&cell.1)
}

/// Whether a cell lies in the rectangle or next to it.
pub(super) fn meets(part: &Block, cell: &Place) -> bool {
    let along = |low: u32, high: u32, k: u32| k + 1 >= low && k <= high + 1;
    along(part[0].0, part[1].0, cell.0) && along(part[0].1, part[1].1, cell.1)
}
