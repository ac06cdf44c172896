//! Storing iterations durably: every 201 means a synced write-ahead log. The database lies in the
//! target folder, so the disk under it is measured.

use divan::{Bencher, counter::ItemsCount};
use serde_json::Value;

use load::{Press, Server, post};

/// 20 nodes, degree (2,2).
const ITERATION: &str = include_str!("../../examples/requests/iteration.json");
/// 135 nodes, degree (2,2).
const FLANK: &str = include_str!("../../examples/flank_z52.json");

/// Requests of a round: so many that 64 connections wait together for the log again and again.
const ROUND: usize = 1280;

#[divan::bench(args = [1, 8, 64], sample_size = 1, max_time = 5)]
fn iterations_of_20_nodes(bencher: Bencher, connections: usize) {
    rounds(bencher, ITERATION, connections);
}

#[divan::bench(args = [1, 8, 64], sample_size = 1, max_time = 5)]
fn iterations_of_135_nodes(bencher: Bencher, connections: usize) {
    rounds(bencher, FLANK, connections);
}

fn rounds(bencher: Bencher, body: &str, connections: usize) {
    let server = Server::start(env!("CARGO_TARGET_TMPDIR"));
    let (status, job) = load::once(server.address, &post("/v1/jobs", r#"{"name":"bench"}"#));
    assert_eq!(status, 201, "{}", String::from_utf8_lossy(&job));
    let job: Value = serde_json::from_slice(&job).expect("a job is JSON");
    let path = format!("/v1/jobs/{}/iterations", job["id"].as_str().expect("a job has an id"));
    let request = post(&path, body);
    let mut press = Press::new(server.address, connections);
    bencher.counter(ItemsCount::new(ROUND)).bench_local(|| press.round(&request, ROUND));
}
