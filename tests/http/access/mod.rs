//! Access of clients: TLS, limits on callers, the listener for operation, draining.

mod callers;
mod collector;
mod draining;
mod fairness;
mod first_key;
mod health;
mod issuer;
pub mod keys;
mod lines;
mod metrics;
mod roles;
mod secrecy;
mod secret_files;
mod sites;
mod talkative;
mod tls;
mod tokens;
mod traces;
