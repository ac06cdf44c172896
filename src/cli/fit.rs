//! `flankfit fit FILE`: the answer of `POST /v1/fits` without a server.

use std::{io::Write as _, path::PathBuf};

use clap::Args;

use super::{CommandError, content_of, out::out, progress, wrong_in};
use crate::api::fits::service;

#[derive(Debug, Args)]
pub struct FitArguments {
    /// A fit request as JSON; `-` reads standard input.
    file: PathBuf,
}

/// Prints the answer to standard output and errors in the request to standard error.
pub fn run(arguments: &FitArguments) -> Result<(), CommandError> {
    let text = content_of(&arguments.file, "a fit request as JSON")?;
    if text.trim_ascii_start().first() != Some(&b'{') {
        let file = super::called(&arguments.file);
        return Err(format!(
            "{file} holds no fit request: that is an object with `nodes` and `model`, as examples/requests/fit_grid.json \
             is. A table of nodes is shown by `flankfit demo --nodes {file}`"
        )
        .into());
    }
    let mut answer =
        progress::shown("fit", || service::fit_json(&text)).map_err(|problem| wrong_in(&arguments.file, &problem))?;
    answer.push(b'\n');
    Ok(out().write_all(&answer)?)
}
