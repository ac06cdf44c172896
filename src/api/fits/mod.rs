//! Fits: requests and how they are read, answers, and the digest of what was fitted.

pub mod answer;
pub mod canonical;
pub mod nodes_text;
pub mod reader;
pub mod service;
pub mod spec;
