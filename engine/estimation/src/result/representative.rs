//! Match of the matrix B of a representative piece with the nodes.

use crate::spec::PieceOf;

/// Fit of the matrix B of a representative piece to these nodes.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = RepresentativeResult)
)]
pub struct RepresentativeReport {
    /// The stored fit that it is of, where it was found in one.
    #[cfg_attr(feature = "contract", serde(flatten))]
    pub of: PieceOf,
    /// Cosine of the largest angle between the regularised directions of the piece and as many
    /// directions of these nodes, those with the smallest eigenvalues: 1 where they agree, as
    /// for nodes at the same places. Below 0.95 the warning `representative_misaligned` gives
    /// the share of the error that remains.
    pub alignment: f64,
}
