//! The list of 10,000 jobs, over one connection.

use divan::Bencher;

use load::{Press, Server, post};

const JOBS: usize = 10_000;
const JOB: &str = include_str!("../../examples/requests/job.json");

/// `q=none` is found in no job, so all of them are looked at.
#[divan::bench(args = ["", "?limit=200", "?sort=name", "?q=pump", "?q=none", "?tag=shift:none"], max_time = 5)]
fn page_of_jobs(bencher: Bencher, query: &str) {
    read(bencher, &format!("/v1/jobs{query}"));
}

#[divan::bench(max_time = 5)]
fn summary_of_jobs(bencher: Bencher) {
    read(bencher, "/v1/jobs/summary");
}

fn read(bencher: Bencher, path: &str) {
    let server = Server::start(env!("CARGO_TARGET_TMPDIR"));
    Press::new(server.address, 50).round(&post("/v1/jobs", JOB), JOBS);
    let request = format!("GET {path} HTTP/1.1\r\nhost: localhost\r\n\r\n").into_bytes();
    let mut press = Press::new(server.address, 1);
    bencher.bench_local(|| press.round(&request, 1));
}
