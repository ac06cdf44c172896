//! Profiles: the lines along which a filter runs.
//!
//! A curve is one line, its nodes sorted by x. A grid has a line along u for each v, and one along
//! v for each u. A measurement matrix is one line in the order of its rows, for what needs an order
//! but no distances.

use crate::{data::Nodes, spec::FilterAxis};
use flankfit_numerics::cancel;

/// Lines that share their positions.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    /// Positions, ascending; equal ones are repeated measurements.
    pub x: Vec<f64>,
    /// Length of axis that belongs to each place: half the way to both neighbours, at the ends the
    /// whole way to the only one, shared among repeated measurements. Equal spacing gives equal
    /// cells.
    pub cell: Vec<f64>,
    /// Number of lines.
    pub count: usize,
    layout: Layout,
}

#[derive(Clone, Debug)]
enum Layout {
    /// Node `line · a + place · b`.
    Strided { line: usize, place: usize },
    /// Node `order[place]`.
    Sorted(Vec<usize>),
}

impl Lines {
    /// The lines of `nodes` along `axis` (`u` for a curve); `None` for scattered nodes.
    pub(super) fn of(nodes: &Nodes, axis: FilterAxis) -> Option<Self> {
        match nodes {
            Nodes::Curve(curve) => {
                let mut order: Vec<usize> = (0..curve.x.len()).collect();
                order.sort_by(cancel::comparing(|&i: &usize, &j: &usize| {
                    curve.x[i].total_cmp(&curve.x[j]).then(i.cmp(&j))
                }));
                let x = order.iter().map(|&i| curve.x[i]).collect();
                Some(Self::new(x, 1, Layout::Sorted(order)))
            }
            Nodes::Grid(grid) => Some(match axis {
                FilterAxis::U => {
                    Self::new(grid.u.clone(), grid.v.len(), Layout::Strided { line: 1, place: grid.v.len() })
                }
                FilterAxis::V => {
                    Self::new(grid.v.clone(), grid.u.len(), Layout::Strided { line: grid.v.len(), place: 1 })
                }
            }),
            Nodes::Matrix(matrix) => {
                let x = (0..matrix.y.len()).map(|i| i as f64).collect();
                Some(Self::new(x, 1, Layout::Strided { line: 0, place: 1 }))
            }
            Nodes::Scattered(_) => None,
        }
    }

    /// One line with these ascending positions.
    pub(super) fn single(x: &[f64]) -> Self {
        Self::new(x.to_vec(), 1, Layout::Strided { line: 0, place: 1 })
    }

    fn new(x: Vec<f64>, count: usize, layout: Layout) -> Self {
        Lines { cell: cells(&x), x, count, layout }
    }

    /// Places on each line.
    pub(super) fn places(&self) -> usize {
        self.x.len()
    }

    /// The posted node at a place of a line.
    #[inline(always)]
    pub(super) fn node(&self, line: usize, place: usize) -> usize {
        match &self.layout {
            Layout::Strided { line: a, place: b } => line * a + place * b,
            Layout::Sorted(order) => order[place],
        }
    }

    /// The least distance of two different positions; infinite where there are none.
    pub(super) fn closest(&self) -> f64 {
        self.x.windows(2).map(|pair| pair[1] - pair[0]).filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min)
    }
}

/// Cells of ascending positions.
pub(super) fn cells(x: &[f64]) -> Vec<f64> {
    let mut cells = vec![1.0; x.len()];
    // the different positions, and where their measurements begin
    let starts: Vec<usize> = (0..x.len()).filter(|&i| i == 0 || x[i] > x[i - 1]).collect();
    if starts.len() < 2 {
        return cells;
    }
    for (k, &start) in starts.iter().enumerate() {
        let end = starts.get(k + 1).copied().unwrap_or(x.len());
        let before = k.checked_sub(1).map(|k| x[start] - x[starts[k]]);
        let after = starts.get(k + 1).map(|&next| x[next] - x[start]);
        let width = match (before, after) {
            (Some(before), Some(after)) => 0.5 * before + 0.5 * after,
            (Some(width), None) | (None, Some(width)) => width,
            (None, None) => 1.0,
        };
        cells[start..end].fill(width / (end - start) as f64);
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_extend_halfway_to_their_neighbours() {
        assert_eq!(cells(&[0.0, 1.0, 2.0, 3.0]), [1.0; 4]);
        assert_eq!(cells(&[0.0, 1.0, 3.0]), [1.0, 1.5, 2.0]);
        assert_eq!(cells(&[0.0, 1.0, 1.0, 2.0]), [1.0, 0.5, 0.5, 1.0]);
        assert_eq!(cells(&[5.0, 5.0]), [1.0, 1.0]);
    }

    #[test]
    fn lines_reach_every_node_once() {
        let grid =
            Nodes::grid(vec![0.0, 1.0], vec![0.0, 1.0, 4.0], (0..6).map(f64::from).collect(), None, None).unwrap();
        for (axis, lines, places) in [(FilterAxis::U, 3, 2), (FilterAxis::V, 2, 3)] {
            let along = Lines::of(&grid, axis).unwrap();
            assert_eq!((along.count, along.places()), (lines, places));
            let mut seen: Vec<usize> =
                (0..lines).flat_map(|l| (0..places).map(move |p| (l, p))).map(|(l, p)| along.node(l, p)).collect();
            seen.sort_unstable();
            assert_eq!(seen, [0, 1, 2, 3, 4, 5]);
        }
        let curve = Nodes::curve(vec![2.0, 0.0, 1.0], vec![0.0; 3], None).unwrap();
        let line = Lines::of(&curve, FilterAxis::U).unwrap();
        assert_eq!([0, 1, 2].map(|place| line.node(0, place)), [1, 2, 0]);
        assert_eq!(line.closest(), 1.0);
    }
}
