//! Rows of a measurement matrix whose errors have been made white.

use flankfit_numerics::Dd;

/// Whitened values by counted node: the working columns, the height, and the constant.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WhiteRows {
    pub width: usize,
    pub rows: Vec<Dd>,
}

impl WhiteRows {
    /// Nodes.
    pub(crate) fn count(&self) -> usize {
        self.rows.len() / self.width
    }

    /// The working columns of counted node `k`.
    pub(crate) fn columns(&self, k: usize) -> &[Dd] {
        &self.rows[k * self.width..][..self.width - 2]
    }

    /// The height of counted node `k`.
    pub(crate) fn height(&self, k: usize) -> Dd {
        self.rows[(k + 1) * self.width - 2]
    }

    /// Whitened entry of the constant column at counted node `k`.
    pub(crate) fn one(&self, k: usize) -> Dd {
        self.rows[(k + 1) * self.width - 1]
    }
}
