//! HTTP: one file per endpoint group, and what they share (bodies, problems, the layer around every request).

pub mod auth;
pub mod body;
pub mod closing;
pub mod compute;
pub mod conditional;
mod curves;
pub mod docs;
pub mod events;
mod extract;
mod files;
pub mod fits;
pub mod idempotency;
pub mod iterations;
pub mod job_fits;
pub mod jobs;
pub mod meta;
pub mod multipart;
pub mod observe;
pub mod openapi;
mod paging;
pub mod problem;
pub mod router;
pub mod server;
mod shapes;
pub mod state;
pub mod stream_flow;
mod stream_socket;
mod streams;
pub mod studies;
mod surfaces;
mod trace;

pub use router::router;
pub use state::AppState;
