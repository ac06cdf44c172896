//! The longer commands of this repository: `cargo xtask` lists them.
//!
//! Each is what documents would otherwise ask people to type. None is needed to build or to test,
//! and the gate (`.ci/run`) does without this program.

mod commands;
mod shell;

use std::process::ExitCode;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let Some(name) = arguments.next() else {
        print!("{}", commands::help());
        return ExitCode::SUCCESS;
    };
    let rest: Vec<String> = arguments.collect();
    match commands::run_command(&name, &rest) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("xtask {name}: {reason}");
            ExitCode::FAILURE
        }
    }
}
