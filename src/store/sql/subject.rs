//! The paths of changed things.

use uuid::Uuid;

use crate::jobs::{KeyId, Tenant};

pub fn job(job: Uuid) -> String {
    format!("/v1/jobs/{job}")
}

pub fn iteration(job: Uuid, number: u32) -> String {
    format!("/v1/jobs/{job}/iterations/{number}")
}

pub fn fit(job: Uuid, number: u32, fit: Uuid) -> String {
    format!("/v1/jobs/{job}/iterations/{number}/fits/{fit}")
}

pub fn record(job: Uuid, number: u32, record: Uuid) -> String {
    format!("/v1/jobs/{job}/iterations/{number}/records/{record}")
}

pub fn key(key: KeyId) -> String {
    format!("/v1/keys/{key}")
}

pub fn tenant(name: &Tenant) -> String {
    format!("/v1/tenants/{}", name.as_str())
}

pub fn stream(stream: Uuid) -> String {
    format!("/v1/streams/{stream}")
}

pub fn block(stream: Uuid, sequence: u64) -> String {
    format!("/v1/streams/{stream}/blocks/{sequence}")
}
