//! Nodes bucketed by the cell (one span of u, one of v) that they lie in.
//!
//! Nodes of a cell share all their functions, so sums over them stay small and close together.
//! Copies are in the order of the cells: a pass is one read of memory from end to end, and sums are
//! the same however many threads work.

use super::pieces::Pieces;
use flankfit_numerics::cancel::Asking;

/// Counted nodes in the order of their cells.
pub(crate) struct Cells {
    pub u: Vec<f64>,
    pub v: Vec<f64>,
    pub weight: Option<Vec<f64>>,
    /// Heights of each coordinate.
    pub heights: Vec<Vec<f64>>,
    /// Index of the posted node of each.
    pub posted: Vec<u32>,
    /// Start of cell `i` of u and `j` of v among the nodes: entry `i · (spans of v) + j`; one more
    /// entry at the end.
    pub start: Vec<usize>,
    pub spans: [usize; 2],
}

/// Nodes as they were posted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Places<'a> {
    pub u: &'a [f64],
    pub v: &'a [f64],
    pub heights: &'a [Vec<f64>],
    pub weight: Option<&'a [f64]>,
}

impl Cells {
    /// Buckets the nodes of weight above 0, keeping the order posted within a cell.
    pub(crate) fn new(places: &Places, u: &Pieces<f64>, v: &Pieces<f64>) -> Self {
        let spans = [u.count(), v.count()];
        let counts = |k: usize| places.weight.is_none_or(|w| w[k] > 0.0);
        let cell = |k: usize| u.span_of(places.u[k]) * spans[1] + v.span_of(places.v[k]);
        let mut start = vec![0usize; spans[0] * spans[1] + 1];
        let cells: Vec<u32> =
            (0..places.u.len()).asking(20).map(|k| if counts(k) { cell(k) as u32 } else { u32::MAX }).collect();
        for &cell in cells.iter().filter(|&&cell| cell != u32::MAX) {
            start[cell as usize + 1] += 1;
        }
        for i in 1..start.len() {
            start[i] += start[i - 1];
        }
        let count = start[start.len() - 1];
        let mut posted = vec![0u32; count];
        let mut next = start.clone();
        for (k, &cell) in cells.iter().enumerate().asking(10).filter(|(_, cell)| **cell != u32::MAX) {
            posted[next[cell as usize]] = k as u32;
            next[cell as usize] += 1;
        }
        drop(cells);
        let take = |from: &[f64]| posted.iter().asking(10).map(|&k| from[k as usize]).collect::<Vec<f64>>();
        Cells {
            u: take(places.u),
            v: take(places.v),
            weight: places.weight.map(take),
            heights: places.heights.iter().map(|z| take(z)).collect(),
            posted,
            start,
            spans,
        }
    }

    /// Counted nodes.
    pub(crate) fn count(&self) -> usize {
        self.posted.len()
    }

    /// Nodes of each cell, the spans of v running fastest.
    pub(crate) fn nodes_per_cell(&self) -> Vec<usize> {
        self.start.windows(2).map(|ends| ends[1] - ends[0]).collect()
    }

    /// Weight of the node at place `k` of this order.
    #[inline(always)]
    pub(crate) fn w(&self, k: usize) -> f64 {
        self.weight.as_ref().map_or(1.0, |w| w[k])
    }
}
