//! Cross-validation of a filter: the sum of squares of the residuals of nodes that are left out,
//! one by one or in blocks, the penalty held.

use super::blockwise::Blockwise;
use flankfit_numerics::cancel::Asking;

/// Unit in which nodes are left out.
pub(crate) enum LeftOut {
    OneByOne(Nodewise),
    /// With what the heights have along the directions that are filtered.
    InBlocks(Blockwise, Vec<f64>),
}

impl LeftOut {
    /// `Σ w r²` of the nodes left out where `removed` of each direction is taken away; infinite
    /// where the others do not determine them.
    pub(crate) fn sum(&self, removed: &[f64]) -> f64 {
        match self {
            LeftOut::OneByOne(nodes) => nodes.press(removed),
            LeftOut::InBlocks(blocks, heights) => blocks.sum(removed, heights),
        }
    }
}

/// The nodes in the coordinates of the directions that are filtered.
pub(crate) struct Nodewise {
    /// For each node what it has along each direction, of length 1 over all nodes: rows end to end.
    pub along: Vec<f64>,
    /// Coordinates of the heights along each direction.
    pub heights: Vec<f64>,
    /// √w times the residuals of least squares.
    pub residuals: Vec<f64>,
    /// 1 less the leverages in least squares.
    pub left: Vec<f64>,
}

/// 1 − h below this is 0 to rounding.
const UNDETERMINED: f64 = 1e-10;

impl Nodewise {
    /// `Σ w r²/(1 − h)²` where `removed` of each direction is taken away; infinite where a node is
    /// not determined by the others.
    fn press(&self, removed: &[f64]) -> f64 {
        let moved: Vec<f64> = removed.iter().zip(&self.heights).map(|(g, b)| g * b).collect();
        let rows = self.along.chunks_exact(removed.len().max(1));
        let nodes = self.residuals.iter().zip(&self.left).zip(rows).asking(4 * removed.len());
        let mut sum = 0.0;
        for ((residual, left), row) in nodes {
            let (mut r, mut rest) = (*residual, *left);
            for ((u, g), b) in row.iter().zip(removed).zip(&moved) {
                r += u * b;
                rest += g * u * u;
            }
            if rest <= UNDETERMINED {
                return f64::INFINITY;
            }
            sum += (r / rest).powi(2);
        }
        sum
    }
}
