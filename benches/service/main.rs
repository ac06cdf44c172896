//! The service over HTTP: `cargo xtask bench service`. A server of this process and keep-alive
//! connections to it. What is timed is a round of requests; the load generator takes its share of
//! the same cores.

mod fits;
mod job_list;
mod store;

/// The one of the program.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() {
    divan::main();
}
