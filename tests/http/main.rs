//! The service over real HTTP: one binary, one harness, one file per subject.

mod dashboard;
mod database;
mod harness;
mod influence;
mod intervals;

mod access;
mod bad_bodies;
mod bad_input;
mod cancellation;
mod constraints;
mod contract;
mod corpus;
mod cors;
mod criteria;
mod defaults;
mod degenerate;
mod document;
mod documents;
mod enclosure;
mod errors;
mod estimators;
mod every_operation;
mod extremes;
mod filters;
mod fits;
mod forms;
mod gears;
mod headers;
#[path = "../store/heard.rs"]
mod heard;
mod jobs;
mod left_out;
mod limits;
mod mutations;
mod operation;
mod plant;
#[path = "../store/server.rs"]
mod postgres;
mod prior;
mod program;
mod readiness;
mod regularization;
mod representative;
mod schema;
mod selection;
mod shapes;
mod slow;
mod strict;
mod studies;
mod tables;
mod wording;
