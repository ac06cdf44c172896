//! HTTP: the endpoints, the layers around them, the OpenAPI document and the server.

mod caller_state;
pub(crate) mod endpoints;
pub(crate) mod layers;
pub mod openapi;
mod router;
pub mod server;
mod shutdown;
pub mod state;

pub use endpoints::dashboard;
pub use router::{operation_router, router};
pub use state::AppState;
