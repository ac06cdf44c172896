//! Which cells of a rectangle the section may pass through, and where within it is simple.
//!
//! Bounds of the height rule cells out, or show that it ascends along a parameter: then the section
//! is one line through the cell. Other cells are halved; what remains is about places without
//! slope, which Newton's method finds.

use std::{
    cell::Cell,
    collections::{BTreeMap, BTreeSet},
};

use super::{
    field::{Bending, Field},
    heights::{Heights, Judged},
};
use flankfit_numerics::cancel::checkpoint;

/// Cells are halved at least and at most so often before a part is looked at by itself.
const LEAST: u32 = 3;
const MOST: u32 = 6;
/// Coefficients that are kept at a time, at most.
const MOST_NUMBERS: usize = 2_000_000;
/// Cells that are halved no more than this make a part of the surface where they lie in the plane.
const LARGE: u32 = 4;

/// Place of a cell or corner on the grid of a rectangle.
pub(super) type Place = (u32, u32);

/// A rectangle of parameters.
pub(super) struct Rectangle<'a> {
    pub field: &'a Field<'a>,
    pub range: [[f64; 2]; 2],
    pub heights: Heights,
    /// How often a part has been looked at by itself.
    pub depth: u32,
    /// Heights that count as 0 where the plane touches, and those that may be rounding.
    pub contact: f64,
    pub rounding: f64,
    /// How many cells of parts may still be looked at.
    pub left: &'a Cell<usize>,
}

/// Result on the finest grid.
#[derive(Default)]
pub(super) struct SearchResult {
    pub level: u32,
    /// One line passes, or none.
    pub simple: BTreeSet<Place>,
    /// Cells around places without slope, connected parts.
    pub knots: Vec<Knot>,
    /// A large cell lies in the plane.
    pub coincident: bool,
}

/// Connected cells around places without slope.
pub(super) struct Knot {
    pub cells: BTreeSet<Place>,
    /// The places without slope and without height that explain them.
    pub places: Vec<([f64; 2], Bending)>,
    /// Whether every cell is explained.
    pub explained: bool,
}

enum State {
    Simple,
    Explained([f64; 2], Bending),
    Open,
}

impl Rectangle<'_> {
    pub(super) fn corner(&self, level: u32, (i, j): Place) -> [f64; 2] {
        let count = f64::from(1_u32 << level);
        let along = |[low, high]: [f64; 2], k: u32| match k {
            0 => low,
            k if f64::from(k) == count => high,
            k => low + (high - low) * (f64::from(k) / count),
        };
        [along(self.range[0], i), along(self.range[1], j)]
    }

    /// The rectangle of the cells between two corners.
    pub(super) fn part(&self, level: u32, [from, to]: [Place; 2]) -> (Heights, [[f64; 2]; 2]) {
        let count = f64::from(1_u32 << level);
        let shares = [[from.0, to.0], [from.1, to.1]].map(|ends| ends.map(|k| f64::from(k) / count));
        let (low, high) = (self.corner(level, from), self.corner(level, to));
        let range = [[low[0], high[0]], [low[1], high[1]]];
        (self.heights.part(self.field, shares, range), range)
    }

    /// Halves cells until each is ruled out, simple, or explained by a place without slope.
    pub(super) fn search(&self) -> SearchResult {
        let mut found = SearchResult::default();
        let mut cells = vec![((0, 0), self.heights.clone())];
        loop {
            if self.depth > 0 {
                self.left.set(self.left.get().saturating_sub(cells.len()));
            }
            let mut states = Vec::with_capacity(cells.len());
            for (cell, heights) in cells {
                if let Some(state) = self.state(found.level, cell, &heights, &mut found.coincident) {
                    states.push((cell, heights, state));
                }
            }
            let open = states.iter().any(|(.., state)| matches!(state, State::Open));
            let knotted = states.iter().any(|(.., state)| matches!(state, State::Explained(..)));
            let enough = found.level >= if knotted { MOST } else { LEAST } && !open;
            let full = states.iter().map(|(_, heights, _)| 4 * heights.size()).sum::<usize>() > MOST_NUMBERS;
            if enough || full || found.level == MOST || states.is_empty() {
                return self.sorted(found, states.into_iter().map(|(cell, _, state)| (cell, state)).collect());
            }
            found.level += 1;
            let quarters = |((i, j), heights, _): (Place, Heights, State)| {
                let places = [(2 * i, 2 * j), (2 * i, 2 * j + 1), (2 * i + 1, 2 * j), (2 * i + 1, 2 * j + 1)];
                places.into_iter().zip(heights.quarters())
            };
            cells = states.into_iter().flat_map(quarters).collect();
        }
    }

    /// `None` where the section cannot pass.
    fn state(&self, level: u32, cell: Place, heights: &Heights, coincident: &mut bool) -> Option<State> {
        checkpoint();
        let ends = [self.corner(level, cell), self.corner(level, (cell.0 + 1, cell.1 + 1))];
        match heights.judge(self.field, ends, self.contact) {
            Judged::Away => return None,
            Judged::Within if self.depth == 0 && level <= LARGE => {
                *coincident = true;
                return None;
            }
            Judged::Monotone => {
                // on sides of the rectangle lines end: a line that leaves and comes back is two
                let last = (1_u32 << level) - 1;
                let sides =
                    [((0, 0), cell.0 == 0), ((0, 1), cell.0 == last), ((1, 0), cell.1 == 0), ((1, 1), cell.1 == last)];
                let passes = |side| heights.passes_once(self.field, ends, side, self.contact);
                let simple = sides.into_iter().all(|(side, own)| !own || passes(side));
                return Some(if simple { State::Simple } else { State::Open });
            }
            Judged::Within | Judged::Unknown => {}
        }
        let [low, high] = ends;
        let middle = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
        let near = if self.depth == 0 { 4.0 } else { 12.0 };
        let reach: [f64; 2] = std::array::from_fn(|k| near * (high[k] - low[k]));
        let place = self.field.stationary(middle, reach).filter(|(at, _)| {
            (0..2).all(|k| (at[k] - middle[k]).abs() <= reach[k]) && self.field.height(*at).abs() <= self.contact
        });
        Some(place.map_or(State::Open, |(at, bending)| State::Explained(at, bending)))
    }

    fn sorted(&self, mut found: SearchResult, states: Vec<(Place, State)>) -> SearchResult {
        let mut rest = BTreeMap::new();
        for (cell, state) in states {
            match state {
                State::Simple => {
                    found.simple.insert(cell);
                }
                other => {
                    rest.insert(cell, other);
                }
            }
        }
        while let Some((first, _)) = rest.first_key_value() {
            let mut knot = Knot { cells: BTreeSet::new(), places: Vec::new(), explained: true };
            let mut next = vec![*first];
            while let Some(cell) = next.pop() {
                let Some(state) = rest.remove(&cell) else { continue };
                knot.cells.insert(cell);
                match state {
                    State::Explained(at, bending) => self.note(&mut knot.places, at, bending),
                    _ => knot.explained = false,
                }
                let around = |k: u32| k.saturating_sub(1)..=k + 1;
                next.extend(around(cell.0).flat_map(|i| around(cell.1).map(move |j| (i, j))));
            }
            found.knots.push(knot);
        }
        found
    }

    fn note(&self, places: &mut Vec<([f64; 2], Bending)>, at: [f64; 2], bending: Bending) {
        let width = |k: usize| self.range[k][1] - self.range[k][0];
        let same = |known: &[f64; 2]| (0..2).all(|k| (known[k] - at[k]).abs() <= 1e-6 * width(k));
        // along a line of contact only that it is one matters
        let known =
            |(place, kind): &([f64; 2], Bending)| *kind == bending && (same(place) || bending == Bending::Trough);
        if !places.iter().any(known) {
            places.push((at, bending));
        }
    }
}
