//! flankfit: robust parametric estimation of tooth-flank surfaces, as an HTTP service.

pub mod api;
pub mod app;
pub mod cli;
pub mod config;
pub mod estimation;
pub mod formats;
pub mod gear;
pub mod geometry;
pub mod http;
pub mod jobs;
pub mod numerics;
pub mod pool;
pub mod store;
pub mod telemetry;
