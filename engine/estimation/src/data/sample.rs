//! The counted nodes of a node set: what is missing or of weight 0 is skipped once, here.

use super::{nodes::Nodes, white_rows::WhiteRows};
use flankfit_numerics::{Dd, Real, lanes::LANES};

/// Counted nodes, borrowed from the node set in the order posted (grids row by row).
pub(crate) struct Sample<'a> {
    places: Places<'a>,
    heights: &'a [f64],
    weight: Option<&'a [f64]>,
    /// Indices of the posted nodes that count; `None` if all do.
    index: Option<Vec<u32>>,
    count: usize,
    /// Whitened rows and heights that replace the posted ones where errors are not white.
    white: Option<&'a WhiteRows>,
}

#[derive(Clone, Copy)]
enum Places<'a> {
    Curve { x: &'a [f64] },
    Scattered { u: &'a [f64], v: &'a [f64] },
    Grid { u: &'a [f64], v: &'a [f64] },
    Matrix { x: &'a [f64], columns: usize },
}

/// Four nodes side by side; where fewer are left the rest repeat a node with weight 0.
#[derive(Clone, Copy)]
pub(crate) struct FourNodes {
    pub u: [f64; LANES],
    pub v: [f64; LANES],
    pub z: [f64; LANES],
    pub w: [f64; LANES],
}

impl<'a> Sample<'a> {
    /// The counted nodes of `nodes`.
    pub(crate) fn new(nodes: &'a Nodes) -> Self {
        let (places, heights, weight) = match nodes {
            Nodes::Curve(c) => (Places::Curve { x: &c.x }, &c.y, &c.weight),
            Nodes::Scattered(s) => (Places::Scattered { u: &s.u, v: &s.v }, &s.z, &s.weight),
            Nodes::Grid(g) => (Places::Grid { u: &g.u, v: &g.v }, &g.z, &g.weight),
            Nodes::Matrix(m) => (Places::Matrix { x: &m.x, columns: m.columns }, &m.y, &m.weight),
        };
        let index = match nodes {
            Nodes::Grid(grid) => counted(heights.len(), |i| grid.counts(i)),
            _ => weight.as_ref().and_then(|w| counted(w.len(), |i| w[i] > 0.0)),
        };
        let count = index.as_ref().map_or(heights.len(), Vec::len);
        Sample { places, heights, weight: weight.as_deref(), index, count, white: None }
    }

    /// The same counted nodes with other weights, one for each posted node; 0 silences a node
    /// without leaving it out.
    pub(crate) fn reweighted<'b>(&self, weight: &'b [f64]) -> Sample<'b>
    where
        'a: 'b,
    {
        Sample {
            places: self.places,
            heights: self.heights,
            weight: Some(weight),
            index: self.index.clone(),
            count: self.count,
            white: None,
        }
    }

    /// The same counted nodes with rows and heights made white, which weigh 1.
    pub(crate) fn whitened<'b>(&self, white: &'b WhiteRows) -> Sample<'b>
    where
        'a: 'b,
    {
        Sample {
            places: self.places,
            heights: self.heights,
            weight: None,
            index: self.index.clone(),
            count: self.count,
            white: Some(white),
        }
    }

    /// True if rows are at hand and no functions of places.
    pub(crate) fn is_white(&self) -> bool {
        self.white.is_some()
    }

    /// The row of the working matrix of counted node `k`, where it is at hand.
    #[inline(always)]
    pub(crate) fn white_columns(&self, k: usize) -> Option<&[Dd]> {
        self.white.map(|white| white.columns(k))
    }

    /// The height of counted node `k` with all its digits.
    #[inline(always)]
    pub(crate) fn height<T: Real>(&self, k: usize) -> T {
        self.white.map_or_else(|| T::of(self.heights[self.posted(k)]), |white| T::of_dd(white.height(k)))
    }

    /// The constant at counted node `k`.
    #[inline(always)]
    pub(crate) fn one(&self, k: usize) -> f64 {
        self.white.map_or(1.0, |white| white.one(k).to_f64())
    }

    /// m, the number of counted nodes.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Indices of the posted nodes that count; `None` if all do.
    pub(crate) fn index(&self) -> Option<&[u32]> {
        self.index.as_deref()
    }

    /// The heights as posted, when all of them count.
    pub(crate) fn all_heights(&self) -> Option<&[f64]> {
        (self.index.is_none() && self.white.is_none()).then_some(self.heights)
    }

    /// The axes of a grid on which every node counts.
    pub(crate) fn full_axes(&self) -> Option<(&[f64], &[f64])> {
        match self.places {
            Places::Grid { u, v } if self.index.is_none() && self.white.is_none() => Some((u, v)),
            _ => None,
        }
    }

    /// True if this is a full, unweighted grid, so that its measurement matrix separates into those
    /// of its axes.
    pub(crate) fn separates(&self) -> bool {
        self.full_axes().is_some() && !self.weighted()
    }

    /// True if any node carries a weight of its own.
    pub(crate) fn weighted(&self) -> bool {
        self.weight.is_some()
    }

    /// Posted number of counted node `k`.
    #[inline(always)]
    pub(crate) fn posted(&self, k: usize) -> usize {
        self.index.as_ref().map_or(k, |index| index[k] as usize)
    }

    /// Height of counted node `k`.
    #[inline(always)]
    pub(crate) fn z(&self, k: usize) -> f64 {
        self.white.map_or_else(|| self.heights[self.posted(k)], |white| white.height(k).to_f64())
    }

    /// Weight of counted node `k`.
    #[inline(always)]
    pub(crate) fn w(&self, k: usize) -> f64 {
        self.weight.map_or(1.0, |w| w[self.posted(k)])
    }

    /// Abscissae of counted node `k`; v is 0 for curves. (Matrix nodes have none: 0, 0.)
    #[inline(always)]
    pub(crate) fn place(&self, k: usize) -> (f64, f64) {
        let i = self.posted(k);
        match self.places {
            Places::Curve { x } => (x[i], 0.0),
            Places::Scattered { u, v } => (u[i], v[i]),
            Places::Grid { u, v } => (u[i / v.len()], v[i % v.len()]),
            Places::Matrix { .. } => (0.0, 0.0),
        }
    }

    /// Row of counted node `k` in the posted measurement matrix (empty for other node sets).
    #[inline(always)]
    pub(crate) fn matrix_row(&self, k: usize) -> &[f64] {
        match self.places {
            Places::Matrix { x, columns } => &x[self.posted(k) * columns..][..columns],
            _ => &[],
        }
    }

    /// Counted nodes `start .. start + 4`.
    #[inline(always)]
    pub(crate) fn four(&self, start: usize) -> FourNodes {
        let mut four = FourNodes { u: [0.0; LANES], v: [0.0; LANES], z: [0.0; LANES], w: [1.0; LANES] };
        if start + LANES <= self.count && self.index.is_none() && self.white.is_none() {
            match self.places {
                Places::Scattered { u, v } => {
                    four.u.copy_from_slice(&u[start..start + LANES]);
                    four.v.copy_from_slice(&v[start..start + LANES]);
                }
                Places::Curve { x } => four.u.copy_from_slice(&x[start..start + LANES]),
                Places::Grid { u, v } => {
                    let (mut row, mut column) = (start / v.len(), start % v.len());
                    for i in 0..LANES {
                        (four.u[i], four.v[i]) = (u[row], v[column]);
                        column += 1;
                        if column == v.len() {
                            (row, column) = (row + 1, 0);
                        }
                    }
                }
                Places::Matrix { .. } => {}
            }
            four.z.copy_from_slice(&self.heights[start..start + LANES]);
            if let Some(weight) = self.weight {
                four.w.copy_from_slice(&weight[start..start + LANES]);
            }
            return four;
        }
        for i in 0..LANES {
            let k = (start + i).min(self.count - 1);
            (four.u[i], four.v[i]) = self.place(k);
            four.z[i] = self.z(k);
            four.w[i] = if start + i < self.count { self.w(k) } else { 0.0 };
        }
        four
    }
}

/// The numbers that count, or `None` when all do.
fn counted(length: usize, counts: impl Fn(usize) -> bool) -> Option<Vec<u32>> {
    let first_gap = (0..length).find(|&i| !counts(i))?;
    let mut index: Vec<u32> = Vec::with_capacity(length);
    index.extend((0..first_gap).map(|i| i as u32));
    index.extend((first_gap..length).filter(|&i| counts(i)).map(|i| i as u32));
    Some(index)
}
