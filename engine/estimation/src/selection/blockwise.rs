//! Residuals of nodes that are left out in blocks, from sums over the blocks alone.
//!
//! In orthonormal coordinates in which the estimate keeps `fᵢ` of what the heights have along
//! direction i, the block B has rows U, residuals r and leaves `(I − U F Uᵀ)⁻¹ r` when it is left
//! out, the penalty held. With `S = F^½ UᵀU F^½` and `g = F^½ Uᵀr` its squared length is
//!
//! `‖r‖² + 2 gᵀx + xᵀSx`, `x = (I − S)⁻¹ g`,
//!
//! since `(I − U F Uᵀ)⁻¹ = I + U F^½ (I − S)⁻¹ F^½ Uᵀ`.

use nalgebra::{DMatrix, DVector};

use flankfit_numerics::{cancel::Asking, triangular};

/// Pivots of `I − S` below this are 0 to rounding: the other nodes do not determine the block.
const UNDETERMINED: f64 = 1e-10;

/// Sums over one block.
#[derive(Clone)]
pub(crate) struct Block {
    /// `UᵀU`.
    pub inner: DMatrix<f64>,
    /// `Uᵀr` and `‖r‖²`, r being √w times the residuals.
    pub cross: DVector<f64>,
    pub rss: f64,
    /// Σw.
    pub weight: f64,
}

impl Block {
    fn empty(size: usize) -> Self {
        Block { inner: DMatrix::zeros(size, size), cross: DVector::zeros(size), rss: 0.0, weight: 0.0 }
    }
}

/// Sums over every block.
pub(crate) struct Blockwise {
    pub blocks: Vec<Block>,
}

impl Blockwise {
    /// No node in any of `count` blocks.
    pub(crate) fn empty(count: usize, size: usize) -> Self {
        Blockwise { blocks: vec![Block::empty(size); count] }
    }

    /// A node of `block` with √w times its row and residual.
    pub(crate) fn add(&mut self, block: usize, row: &[f64], residual: f64, weight: f64) {
        let Block { inner, cross, rss, weight: sum } = &mut self.blocks[block];
        let n = row.len();
        for (column, &x) in inner.as_mut_slice().chunks_exact_mut(n.max(1)).zip(row) {
            column.iter_mut().zip(row).for_each(|(s, &y)| *s += x * y);
        }
        cross.iter_mut().zip(row).for_each(|(g, &x)| *g += residual * x);
        *rss += residual * residual;
        *sum += weight;
    }

    /// `Σ w r²` of the nodes left out, where the estimate takes `removed[i]` of `heights[i]` away
    /// along direction i; infinite where the others do not determine a block. Other directions keep
    /// everything.
    pub(crate) fn sum(&self, removed: &[f64], heights: &[f64]) -> f64 {
        let size = self.blocks.first().map_or(0, |block| block.cross.len());
        let taken = |i: usize| removed.get(i).copied().unwrap_or(0.0);
        let moved = DVector::from_fn(size, |i, _| taken(i) * heights.get(i).copied().unwrap_or(0.0));
        let root: Vec<f64> = (0..size).map(|i| (1.0 - taken(i)).max(0.0).sqrt()).collect();
        let each = self.blocks.iter().asking(size * size * size).map(|block| {
            let (cross, rss) = moved_by(block, &moved);
            let inner = DMatrix::from_fn(size, size, |i, j| root[i] * block.inner[(i, j)] * root[j]);
            left_out(&inner, DVector::from_fn(size, |i, _| root[i] * cross[i]), rss)
        });
        each.sum::<Option<f64>>().unwrap_or(f64::INFINITY)
    }
}

/// `Uᵀr` and `‖r‖²` after the fitted heights have moved by `−U d`.
pub(crate) fn moved_by(block: &Block, d: &DVector<f64>) -> (DVector<f64>, f64) {
    let along = &block.inner * d;
    let rss = block.rss + 2.0 * block.cross.dot(d) + along.dot(d);
    (&block.cross + along, rss.max(0.0))
}

/// The squared length of what a block leaves when it is left out; `None` where the others do not
/// determine it.
pub(crate) fn left_out(inner: &DMatrix<f64>, cross: DVector<f64>, rss: f64) -> Option<f64> {
    let n = inner.nrows();
    let rest = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j)) - inner[(i, j)]);
    let r = triangular::cholesky(&rest)?;
    if (0..n).any(|i| r[(i, i)] * r[(i, i)] <= UNDETERMINED) {
        return None;
    }
    let mut x = cross.clone();
    triangular::solve_upper_transposed(&r, x.as_mut_slice());
    triangular::solve_upper(&r, x.as_mut_slice());
    Some(rss + 2.0 * cross.dot(&x) + (inner * &x).dot(&x))
}
