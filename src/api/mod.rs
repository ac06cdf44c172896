//! The wire types of requests and responses, and their conversion to checked domain types.
//!
//! Knows serde and the OpenAPI schemas, no HTTP server and no SQL, so that the store and the
//! command line use it too. One folder for each feature; imports go upwards in this list: `json`,
//! `measurand`, `tables`, `shapes`, `fits`, `curves`, `surfaces`, `studies`, `gears`, `jobs`,
//! `streams`, `simulations`. `contract` shapes the published document and knows none of them.

pub mod built;
pub mod callers;
pub mod contract;
pub mod curves;
pub mod examples;
pub mod faults;
pub mod fits;
pub mod gears;
pub mod jobs;
pub mod json;
pub mod measurand;
pub mod page;
pub mod problem;
pub mod progress;
pub mod shapes;
pub mod simulations;
pub mod streams;
pub mod studies;
pub mod surfaces;
pub mod tables;
pub mod warning;

/// Engine name and version, as results carry it.
pub const ENGINE: &str = concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION"));
