//! Errors of the nodes that are not white.

pub(super) mod lines;
pub(super) mod serial;
