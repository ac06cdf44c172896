//! What a plant runs by: the proxy, the documents and the manifests, as they are in the repository.

mod commands;
mod manifests;
pub mod proxy;
mod rolling;
mod studies;
mod yaml;
