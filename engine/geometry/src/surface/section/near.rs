//! Places within a distance of a place, without examining every one.

use std::collections::BTreeMap;

use crate::space::Vector;

/// Places by cells as wide as the distance.
pub(super) struct Near {
    width: f64,
    cells: BTreeMap<[i64; 3], Vec<(usize, Vector)>>,
}

impl Near {
    pub(super) fn within(width: f64) -> Self {
        Near { width, cells: BTreeMap::new() }
    }

    fn cell(&self, point: &Vector) -> [i64; 3] {
        // what is far out shares a cell, which costs time only
        std::array::from_fn(|k| (point[k] / self.width).floor() as i64)
    }

    pub(super) fn insert(&mut self, index: usize, point: Vector) {
        let cell = self.cell(&point);
        self.cells.entry(cell).or_default().push((index, point));
    }

    /// The places within the distance, with how far they are.
    pub(super) fn of(&self, point: &Vector) -> impl Iterator<Item = (usize, f64)> + use<'_> {
        let point = *point;
        let [i, j, k] = self.cell(&point);
        let around = |k: i64| k.saturating_sub(1)..=k.saturating_add(1);
        around(i)
            .flat_map(move |i| around(j).flat_map(move |j| around(k).map(move |k| [i, j, k])))
            .filter_map(|cell| self.cells.get(&cell))
            .flatten()
            .map(move |(index, other)| (*index, (other - point).norm()))
            .filter(|(_, distance)| *distance <= self.width)
    }
}

/// Returns the first of places within `near` of each other.
pub(super) fn distinct(points: &mut Vec<Vector>, near: f64) {
    let mut known = Near::within(near);
    points.retain(|point| {
        let new = known.of(point).next().is_none();
        if new {
            known.insert(0, *point);
        }
        new
    });
}
