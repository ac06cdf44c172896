//! Choice of a model: the criteria of every candidate, and the best one.
//!
//! The nodes are factored once, for the largest model. A smaller one has some of its columns, and
//! its factor is a QR of those columns of R: no candidate looks at the nodes again but for its
//! leverages.

mod backward;
mod candidates;
mod chosen;
mod elastic_net;
mod path;
mod problem;
mod subspace;
mod terms;

pub(super) use chosen::choose;
