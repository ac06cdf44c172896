//! `flankfit study [FILE]`: the answer of `POST /v1/studies/randomization` as tables; also in
//! parts, on several machines.

mod parts;
mod raw;
mod tables;

use std::{io::Write, path::PathBuf};

use clap::{Args, Subcommand};

use super::{CommandError, content_of, out::out, progress};
use crate::api::{
    problem::Problem,
    studies::result::{self, RandomizationResult},
};

/// An involute section, described in docs/explanation/paper-figures.md.
const DEFAULT: &str = include_str!("../../../examples/requests/study_flank.json");

#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct StudyArguments {
    #[command(subcommand)]
    command: Option<StudyCommand>,
    /// A study request as JSON; `-` reads standard input. Without it: an involute section whose
    /// columns are nearly parallel.
    file: Option<PathBuf>,
    #[command(flatten)]
    shown: Shown,
    /// Compute only these repetitions, A to B - 1 (counted from 0), or part I of N equal parts (I
    /// from 0), for `study join`.
    #[arg(long, value_name = "A..B|I/N", requires = "raw", conflicts_with_all = ["json", "output"])]
    repetitions: Option<parts::Which>,
    /// File for the results of these repetitions.
    #[arg(long, value_name = "FILE", requires = "repetitions")]
    raw: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum StudyCommand {
    /// Combine the files of all repetitions; the answer is identical, byte for byte, to that of one
    /// run.
    Join(JoinArguments),
}

#[derive(Debug, Args)]
struct JoinArguments {
    /// Files written by `study --repetitions … --raw FILE`, in any order, or folders of them.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    shown: Shown,
}

/// Output of an answer.
#[derive(Debug, Args)]
struct Shown {
    /// Print the answer as JSON instead of tables.
    #[arg(long)]
    json: bool,
    /// Write the answer to this file instead of standard output.
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub fn run(arguments: &StudyArguments) -> Result<(), CommandError> {
    if let Some(StudyCommand::Join(join)) = &arguments.command {
        return join.shown.show(&progress::shown("join", || parts::join(&join.files))?);
    }
    let text = match &arguments.file {
        None => DEFAULT.as_bytes().to_vec(),
        Some(file) => content_of(file, "a study request as JSON")?,
    };
    if let (Some(which), Some(raw)) = (&arguments.repetitions, &arguments.raw) {
        let said = progress::shown("study", || parts::write(text, which, raw))?;
        return Ok(writeln!(out(), "{said}")?);
    }
    let result = progress::shown("study", || result::answer(&text)).map_err(|problem| explain(&problem))?;
    arguments.shown.show(&result)
}

impl Shown {
    fn show(&self, result: &RandomizationResult) -> Result<(), CommandError> {
        let mut shown = if self.json { result.to_json()? } else { tables::text(result).into_bytes() };
        if self.json {
            shown.push(b'\n');
        }
        match &self.output {
            None => Ok(out().write_all(&shown)?),
            Some(file) => {
                std::fs::write(file, &shown).map_err(|error| format!("cannot write {}: {error}", file.display()).into())
            }
        }
    }
}

/// Returns a problem as readable text with its place.
fn explain(problem: &Problem) -> String {
    let mut text = problem.detail.to_string();
    for error in &problem.errors {
        text.push_str(&format!("\n  {}: {}", error.pointer, error.detail));
    }
    text
}
