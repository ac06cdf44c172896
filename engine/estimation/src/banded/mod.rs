//! Least squares of tensor B-splines with thousands of coefficients on millions of scattered nodes.
//!
//! A row of X has (p + 1)(q + 1) entries, and the Fisher information matrix `F = XᵀΩX` is banded
//! with half-bandwidth p·n_v + q. Nodes are bucketed by cell ([`cells`]), F is summed cell by cell
//! ([`passes`]), factored as a band and corrected by residuals from the nodes ([`system`]), which
//! costs O(m (p+1)²(q+1)² + n (p n_v)²) and a small multiple of the nodes in memory. A penalty of
//! order 0 to 3 keeps the band ([`penalty`], [`weight`]). The entry point is
//! [`super::near::surface`].

pub(super) mod cells;
pub(super) mod passes;
pub(super) mod penalty;
pub(super) mod pieces;
pub(super) mod system;
pub(super) mod weight;
