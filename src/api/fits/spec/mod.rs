//! Fit requests: the engine's specification, the nodes, and the names of optional parts.

pub mod include;
pub mod json;
pub mod nodes;
pub mod request;
