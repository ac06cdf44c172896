//! Tables of nodes and points: what is said of one, and the nodes that are made of it.

pub mod kept;
pub mod mapping;
pub mod nodes;
