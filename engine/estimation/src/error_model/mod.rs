//! Errors of the nodes that are not white: correlated along scan lines, or of unequal variance.
//!
//! Correlated errors enter at the measurement matrix: rows of `[X y]` are made white along the
//! lines, and everything after is as in any fit. Where the parameters of the correlation are
//! estimated, the estimate is an average over them. Variances come in as weights, or as a sandwich
//! about least squares.

pub(super) mod lines;
pub(super) mod mixture;
pub(super) mod position_spread;
pub(super) mod positions;
pub(super) mod process;
pub(super) mod restricted;
pub(super) mod sandwich;
pub(super) mod spread;
pub(super) mod unequal;
pub(super) mod variance_spread;
pub(super) mod white;
pub(super) mod whiteness;
