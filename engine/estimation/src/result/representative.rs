//! Match of the matrix B of a representative piece with the nodes.

use crate::spec::PieceOf;

/// How the matrix B of a representative piece suits the nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct RepresentativeReport {
    /// The stored fit that it is of, where it was found in one.
    pub of: PieceOf,
    /// Cosine of the largest angle between the directions of the piece and as many of the nodes'
    /// own, those with the smallest eigenvalues: 1 where both are alike.
    pub alignment: f64,
}
