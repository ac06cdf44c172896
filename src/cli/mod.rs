//! The command line: one file per subcommand, `serve` when none is given.

pub mod audit;
pub mod backup;
pub mod demo;
pub mod evaluate;
pub mod fit;
pub mod healthcheck;
pub mod keys;
pub mod life;
pub mod migrate;
pub mod openapi;
mod out;
mod progress;
mod secrets;
pub mod serve;
pub mod study;
mod table;

use std::{
    env, fs,
    io::{self, Read as _},
    net::SocketAddr,
    path::Path,
    process::ExitCode,
};

use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use tokio::runtime::{Builder, Runtime};

use self::secrets::Refused;
use crate::{api::problem::Problem, config::ServeSettings, telemetry};

/// Robust parametric estimation of tooth-flank surfaces, as an HTTP service.
#[derive(Debug, Parser)]
#[command(name = "flankfit", version, about, args_conflicts_with_subcommands = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    serve: ServeSettings,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Serve HTTP (the default).
    Serve(Box<ServeSettings>),
    /// Show a gear job from first measurement to acceptance, on a server of its own.
    Demo(demo::DemoArguments),
    /// Fit one request from a file (`-` for standard input), offline, with the same engine.
    Fit(fit::FitArguments),
    /// Evaluate a file of a gear tester (.mka, .mew), offline, as a table.
    Evaluate(evaluate::EvaluateArguments),
    /// Randomise a measurement matrix and show the effect on the estimate; by default for the
    /// profile of a flank.
    Study(study::StudyArguments),
    /// Print the OpenAPI document.
    Openapi(openapi::OpenapiArguments),
    /// Copy the database consistently to a new file; a server may be running on it.
    Backup(backup::BackupArguments),
    /// Write jobs with all their data and their audit, as JSON lines.
    Export(life::ExportArguments),
    /// Store the jobs that `flankfit export` or `GET /v1/jobs/…/archive` wrote.
    Import(life::ImportArguments),
    /// Purge jobs without recent activity of nodes, results, texts and names; a server may be
    /// running.
    Purge(life::PurgeArguments),
    /// Create or upgrade the schema of a PostgreSQL database. (SQLite is upgraded at start.).
    Migrate(migrate::MigrateArguments),
    /// Make API keys in the database.
    Keys(keys::KeysArguments),
    /// Verify the audit.
    Audit(audit::AuditArguments),
    /// Check that a running server responds; exit code 0 if it does.
    Healthcheck(healthcheck::HealthcheckArguments),
}

/// Runs the program.
pub fn main() -> ExitCode {
    let arguments = match arguments() {
        Ok(arguments) => arguments,
        Err(refused) => return refused.print(),
    };
    let command = arguments.command.unwrap_or_else(|| Command::Serve(Box::new(arguments.serve)));
    let outcome = match command {
        Command::Serve(settings) => serve::run(*settings),
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Fit(arguments) => fit::run(&arguments),
        Command::Evaluate(arguments) => evaluate::run(&arguments),
        Command::Study(arguments) => study::run(&arguments),
        Command::Openapi(arguments) => openapi::run(&arguments),
        Command::Backup(arguments) => backup::run(&arguments),
        Command::Export(arguments) => life::export(&arguments),
        Command::Import(arguments) => life::import(&arguments),
        Command::Purge(arguments) => life::purge(&arguments),
        Command::Migrate(arguments) => migrate::run(&arguments),
        Command::Keys(arguments) => keys::run(&arguments),
        Command::Audit(arguments) => return audit::run(&arguments),
        Command::Healthcheck(arguments) => healthcheck::run(&arguments),
    };
    telemetry::flush_logs();
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if out::reader_left(&*error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("flankfit: {error}");
            ExitCode::FAILURE
        }
    }
}

fn arguments() -> Result<Arguments, Refused> {
    let matches = secrets::matches(Arguments::command(), env::args_os(), |name| env::var_os(name))?;
    Arguments::from_arg_matches(&matches).map_err(Refused::Said)
}

/// Returns the loopback address in place of one that means all addresses.
fn reachable(mut address: SocketAddr) -> SocketAddr {
    if address.ip().is_unspecified() {
        address.set_ip(match address {
            SocketAddr::V4(_) => std::net::Ipv4Addr::LOCALHOST.into(),
            SocketAddr::V6(_) => std::net::Ipv6Addr::LOCALHOST.into(),
        });
    }
    address
}

/// Returns a runtime of the calling thread.
fn runtime() -> io::Result<Runtime> {
    Builder::new_current_thread().enable_all().build()
}

/// Returns the content of a file, or of standard input for `-`; `what` describes the expected
/// content.
fn content_of(file: &Path, what: &str) -> Result<Vec<u8>, CommandError> {
    let mut content = Vec::new();
    let read = match file.as_os_str() == "-" {
        true => io::stdin().read_to_end(&mut content).map(|_| content),
        false => fs::read(file),
    };
    Ok(read.map_err(|error| {
        let file = called(file);
        format!("cannot read {file} ({error}): name a file that holds {what}, or - for standard input")
    })?)
}

/// Returns the name of a file for messages.
fn called(file: &Path) -> String {
    if file.as_os_str() == "-" { "standard input".to_owned() } else { file.display().to_string() }
}

/// Returns the errors in the content of a file, one line for each place.
fn wrong_in(file: &Path, problem: &Problem) -> CommandError {
    let file = called(file);
    let lines: Vec<String> = match problem.errors.as_slice() {
        [] => vec![format!("{file}: {}", problem.detail)],
        errors => errors.iter().map(|error| format!("{file}: {}: {}", at(&error.pointer), error.detail)).collect(),
    };
    lines.join("\n").into()
}

/// Returns the place of a JSON Pointer in dotted form: `nodes.z.3.7`.
fn at(pointer: &str) -> String {
    match pointer.trim_start_matches('/') {
        "" => "as a whole".to_owned(),
        path => path.replace('/', ".").replace("~1", "/").replace("~0", "~"),
    }
}

/// Error of a subcommand, for a person to read.
pub type CommandError = Box<dyn std::error::Error + Send + Sync>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_their_file() {
        let mut faults = crate::api::faults::Faults::default();
        faults.push("/nodes/z/3/7", "expected a number");
        faults.push("", "expected an object");
        let said = wrong_in(Path::new("flank.json"), &Problem::invalid(faults)).to_string();
        assert_eq!(said, "flank.json: nodes.z.3.7: expected a number\nflank.json: as a whole: expected an object");
    }

    #[test]
    fn an_unspecified_address_is_reached_locally() {
        assert_eq!(reachable("0.0.0.0:80".parse().unwrap()).to_string(), "127.0.0.1:80");
        assert_eq!(reachable("10.0.0.1:80".parse().unwrap()).to_string(), "10.0.0.1:80");
    }
}
