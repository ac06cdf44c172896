//! The wire: what is read from requests and written into answers, and how it becomes checked domain
//! types.
//!
//! Knows serde and the OpenAPI schemas, no HTTP server and no SQL, so that the store and the
//! command line use it too.

pub mod canonical;
pub mod contract;
pub mod criteria;
pub mod estimator_spec;
pub mod events;
pub mod examples;
pub mod faults;
pub mod filters;
pub mod fit_fields;
pub mod fit_result;
pub mod fit_result_parts;
pub mod fit_spec;
pub mod fit_spec_json;
pub mod fit_spec_values;
pub mod fit_text;
pub mod gears;
pub mod job_fits;
pub mod job_iterations;
pub mod job_problem;
pub mod job_trace;
pub mod jobs;
pub mod json_merge;
pub mod json_writer;
pub mod measurand;
pub mod nodes_codec;
pub mod nodes_schema;
pub mod nodes_text;
pub mod problem;
pub mod reader;
pub mod records;
pub mod regularization_json;
pub mod regularization_result;
pub mod regularization_spec;
pub mod robust_result;
pub mod service;
pub mod shapes;
pub mod stream_state;
pub mod streams;
pub mod study;
pub mod study_result;
pub mod text;
pub mod unique;

/// Engine name and version, as results carry it.
pub const ENGINE: &str = concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION"));
