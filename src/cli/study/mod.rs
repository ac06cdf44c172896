//! `flankfit study [FILE]`: the answer of `POST /v1/studies/randomization` as tables, and the
//! paper's Figs. 4 and 5 as SVG.

mod figures;
mod svg;
mod tables;

use std::{
    io::{Read, Write},
    path::{Path, PathBuf},
};

use clap::Args;

use super::{CommandError, progress};
use crate::api::{problem::Problem, studies::result};

/// An involute section, described in docs/paper-figures.md.
const DEFAULT: &str = include_str!("../../../examples/requests/study_flank.json");

#[derive(Debug, Args)]
pub struct StudyArguments {
    /// A study request as JSON; `-` reads standard input. Without it: an involute section whose
    /// columns are nearly parallel.
    file: Option<PathBuf>,
    /// Also write both figures into this folder, as fig4.svg and fig5.svg.
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
    /// Print the answer as JSON instead of tables.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &StudyArguments) -> Result<(), CommandError> {
    let text = match &arguments.file {
        None => DEFAULT.as_bytes().to_vec(),
        Some(file) => read(file)?,
    };
    let result = progress::shown("study", || result::answer(&text)).map_err(|problem| explain(&problem))?;
    let mut shown = if arguments.json { result.to_json()? } else { tables::text(&result).into_bytes() };
    if arguments.json {
        shown.push(b'\n');
    }
    std::io::stdout().write_all(&shown)?;
    if let Some(folder) = &arguments.svg {
        std::fs::create_dir_all(folder).map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
        for (name, figure) in [("fig4.svg", figures::stability(&result)), ("fig5.svg", figures::accuracy(&result))] {
            let path = folder.join(name);
            std::fs::write(&path, figure).map_err(|error| format!("cannot write {}: {error}", path.display()))?;
        }
    }
    Ok(())
}

fn read(file: &Path) -> Result<Vec<u8>, CommandError> {
    if file.as_os_str() == "-" {
        let mut text = Vec::new();
        std::io::stdin().read_to_end(&mut text)?;
        return Ok(text);
    }
    std::fs::read(file).map_err(|error| format!("cannot read {}: {error}", file.display()).into())
}

/// A problem for a person: what is wrong, and where.
fn explain(problem: &Problem) -> String {
    let mut text = problem.detail.to_string();
    for error in &problem.errors {
        text.push_str(&format!("\n  {}: {}", error.pointer, error.detail));
    }
    text
}
