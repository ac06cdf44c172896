//! `flankfit fit FILE`: the answer of `POST /v1/fits` without a server.

use std::{
    io::{Read, Write},
    path::PathBuf,
    process::ExitCode,
};

use clap::Args;

use super::progress;
use crate::api::{fits::service, problem::Problem};

#[derive(Debug, Args)]
pub struct FitArguments {
    /// A fit request as JSON; `-` reads standard input.
    file: PathBuf,
}

/// The answer goes to standard output (exit code 0); a problem goes to standard error as JSON (exit
/// code 1). Of a file that cannot be read one line tells.
pub fn run(arguments: &FitArguments) -> ExitCode {
    let text = match read(arguments) {
        Ok(text) => text,
        Err(error) => {
            eprintln!(
                "flankfit: cannot read {} ({error}): name a file that holds a fit request as JSON, or - for standard \
                 input",
                arguments.file.display()
            );
            return ExitCode::FAILURE;
        }
    };
    let answer = progress::shown("fit", || service::fit_json(&text)).and_then(|mut answer| {
        answer.push(b'\n');
        std::io::stdout().write_all(&answer).map_err(|error| Problem::internal("cannot write").caused_by(error))
    });
    match answer {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            let text = serde_json::to_string_pretty(&problem).unwrap_or_else(|error| error.to_string());
            eprintln!("{text}");
            ExitCode::FAILURE
        }
    }
}

fn read(arguments: &FitArguments) -> std::io::Result<Vec<u8>> {
    if arguments.file.as_os_str() == "-" {
        let mut text = Vec::new();
        std::io::stdin().read_to_end(&mut text).map(|_| text)
    } else {
        std::fs::read(&arguments.file)
    }
}
