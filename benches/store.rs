//! Storing iterations durably: `cargo bench --bench store`. Up to sixty-four connections post
//! iterations; every 201 stands for a synced write-ahead log. The database lies in the target
//! folder: what is measured is the disk under it.

mod load;

use std::time::Duration;

use load::{Load, Server, post};
use serde_json::Value;

const ITERATION: &str = include_str!("../examples/requests/iteration.json");
const FLANK: &str = include_str!("../examples/flank_z52.json");

fn main() {
    let database = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a folder for the database");
    let server = Server::start(format!("sqlite://{}", database.path().join("store.db").display()));
    for (name, body) in [("20 nodes, degree (2,2)", ITERATION), ("135 nodes, degree (2,2)", FLANK)] {
        for connections in [1, 8, 64] {
            let (status, job) = load::once(server.address, &post("/v1/jobs", r#"{"name":"bench"}"#));
            assert_eq!(status, 201, "{}", String::from_utf8_lossy(&job));
            let job: Value = serde_json::from_slice(&job).expect("a job is JSON");
            let path = format!("/v1/jobs/{}/iterations", job["id"].as_str().expect("a job has an id"));
            let request = post(&path, body);
            let load = Load { connections, warm_up: Duration::from_secs(1), measured: Duration::from_secs(5) };
            let report = load::run(server.address, &request, load);
            println!("POST …/iterations, {name}, {connections:>2} connections  {report}");
        }
    }
}
