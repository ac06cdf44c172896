//! flankfit: robust parametric estimation of tooth-flank surfaces, as an HTTP service.

pub mod api;
pub mod app;
pub mod cli;
pub mod config;
pub mod http;
pub mod jobs;
pub mod oidc;
pub mod outgoing;
pub mod pool;
pub mod store;
pub mod telemetry;
pub mod usecases;
