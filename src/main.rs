//! The program: see `flankfit --help`.

use std::process::ExitCode;

/// Answers are built from many short-lived vectors on several threads; this allocator is made for that.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    flankfit::cli::main()
}
