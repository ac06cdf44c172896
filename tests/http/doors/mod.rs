//! How clients come in: TLS, limits on callers, the listener for operation, draining.

mod callers;
mod draining;
mod roles;
mod tls;
