//! A fuzzer of the whole interface: every operation that the service documents, its examples
//! mutated, through the router and over connections. See `fuzz/README.md`.
//!
//! Invariants: no 5xx but 503, no panic, no end of the process, no NaN or infinity, at most 5 s and
//! 300 MB for each request, every refusal a problem whose pointers exist in the request. A seed
//! determines everything but ids and times.

#[path = "../../engine/tests/formats/klingelnberg_file.rs"]
#[expect(dead_code, reason = "the writer is shared by the test binaries, each of which uses a part")]
mod klingelnberg_file;
#[path = "../../engine/tests/formats/rexs_file.rs"]
#[expect(dead_code, reason = "the writer is shared by the test binaries, each of which uses a part")]
mod rexs_file;

mod check;
mod contract;
mod fixture;
mod forms;
mod memory;
mod mutate;
mod node;
mod options;
mod prepare;
mod report;
mod request;
mod rng;
mod send;
mod spool;
mod worker;

use std::process::ExitCode;

use options::{Options, Role};

#[global_allocator]
static ALLOCATOR: memory::Counting = memory::Counting;

fn main() -> ExitCode {
    let options = match Options::read(std::env::args().skip(1)) {
        Ok(Some(options)) => options,
        Ok(None) => return ExitCode::SUCCESS,
        Err(said) => {
            eprintln!("{said}");
            return ExitCode::from(2);
        }
    };
    match options.role {
        Role::Parent => report::run(&options),
        Role::Worker { first, step } => worker::run(&options, first, step),
        Role::Replay { batch, index, alone } => worker::replay(options.seed, batch, index, alone),
    }
}
