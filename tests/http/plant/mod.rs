//! Files of a plant: the proxy, the documents and the manifests, as they are in the repository.

mod commands;
mod manifests;
mod outage;
pub mod proxy;
mod rolling;
mod studies;
mod yaml;
