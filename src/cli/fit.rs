//! `flankfit fit FILE`: the answer of `POST /v1/fits` without a server.

use std::{io::Write as _, path::PathBuf};

use clap::Args;

use super::{CommandError, content_of, demo::node_file, out::out, progress, wrong_in};
use crate::api::fits::service;

#[derive(Debug, Args)]
pub struct FitArguments {
    /// A fit request as JSON, or a table of nodes, which is fitted by a surface of degree 2 or a
    /// curve of degree 3; `-` reads standard input.
    file: PathBuf,
}

/// Prints the answer to standard output and errors in the request to standard error.
pub fn run(arguments: &FitArguments) -> Result<(), CommandError> {
    let mut text = content_of(&arguments.file, "a fit request as JSON or a table of nodes")?;
    if text.trim_ascii_start().first() != Some(&b'{') {
        let sets = node_file::of_content(&arguments.file, &text)?;
        let [set] = &sets[..] else {
            let names: Vec<&str> = sets.iter().map(|set| set.name.as_str()).collect();
            return Err(format!("one flank is fitted at a time; the file has {}", names.join("; ")).into());
        };
        text = serde_json::to_vec(&set.request)?;
    }
    let mut answer =
        progress::shown("fit", || service::fit_json(&text)).map_err(|problem| wrong_in(&arguments.file, &problem))?;
    answer.push(b'\n');
    Ok(out().write_all(&answer)?)
}
