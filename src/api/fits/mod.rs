//! Fits: requests and their readers, responses, and the digest of the input.

pub mod answer;
pub mod canonical;
pub mod nodes_text;
pub mod reader;
pub mod service;
pub mod spec;
