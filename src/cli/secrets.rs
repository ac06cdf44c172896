//! Settings that hold a secret: read from files, too, and shown by no error.
//!
//! For each variable of [`SECRETS`] there is another one with `_FILE` at its end, which names a
//! file with the value. An argument of the command line goes before both, as everywhere.

use std::{ffi::OsString, fs, io, path::PathBuf, process::ExitCode};

use clap::{
    Arg, ArgMatches, Command,
    error::{ContextKind, ContextValue},
    parser::ValueSource,
};

/// Variables of settings that are a secret or have a password as a part.
const SECRETS: [&str; 4] =
    ["FLANKFIT_DATABASE_URL", "FLANKFIT_DATABASE_DIRECT_URL", "FLANKFIT_API_KEYS_SHA256", "OTEL_EXPORTER_OTLP_HEADERS"];
/// Placeholder for a secret in messages.
const HIDDEN: &str = "(not shown)";
/// Exit code for wrong arguments, as in clap.
const USAGE: u8 = 2;

/// Reason why a secret cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum SecretError {
    #[error("{name} and {name}_FILE are both set: leave one of them out")]
    Both { name: &'static str },
    #[error("cannot read {file}, which {name}_FILE names: {source}", file = file.display())]
    File { name: &'static str, file: PathBuf, source: io::Error },
}

/// Reason why the arguments were not read.
#[derive(Debug)]
pub enum Refused {
    /// Help, the version, or the errors in the arguments.
    Said(clap::Error),
    /// The error without parts that may be secret.
    Hidden(String),
    Secret(SecretError),
}

impl Refused {
    /// Prints it and returns the exit code.
    pub fn print(self) -> ExitCode {
        match self {
            Refused::Said(error) => {
                // nobody may listen any more
                let _closed = error.print();
                ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(USAGE))
            }
            Refused::Hidden(text) => {
                eprint!("{text}");
                ExitCode::from(USAGE)
            }
            Refused::Secret(error) => {
                eprintln!("flankfit: {error}");
                ExitCode::from(USAGE)
            }
        }
    }
}

/// The setting that a variable gives a file for, and the file.
type Named = (&'static str, PathBuf);

/// Returns the arguments, with secrets read from the files that variables name. Only files for the
/// given subcommand are read.
pub fn matches(
    command: Command,
    arguments: impl IntoIterator<Item = OsString>,
    variable: impl Fn(&str) -> Option<OsString>,
) -> Result<ArgMatches, Refused> {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let files = SECRETS.iter().filter_map(|&name| Some((name, variable(&format!("{name}_FILE"))?.into())));
    let files: Vec<Named> = files.collect();
    let command = each(command, &|arg| match secret(&arg) {
        Some(name) => with_its_file(arg, name),
        None => arg,
    });
    let parse = |command: Command| {
        let hidden = hidden_flags(&command);
        command.try_get_matches_from(&arguments).map_err(|error| hide(error, &hidden, &arguments))
    };
    if files.is_empty() {
        return parse(command);
    }
    // once to see what is asked for, where none of these is required
    let lenient = each(command.clone(), &|arg| match named(&arg, &files) {
        Some(_) => arg.required(false),
        None => arg,
    });
    let found = read(&command, &parse(lenient)?, &files).map_err(Refused::Secret)?;
    parse(each(command, &|arg| match found.iter().find(|(name, _)| secret(&arg) == Some(*name)) {
        Some((_, value)) => arg.required(false).hide_default_value(true).default_value(value),
        None => arg,
    }))
}

/// A command whose arguments, and those of all below it, are changed.
fn each(command: Command, change: &dyn Fn(Arg) -> Arg) -> Command {
    command.mut_args(change).mut_subcommands(|below| each(below, change))
}

/// The variable of an argument that is a secret.
fn secret(arg: &Arg) -> Option<&'static str> {
    SECRETS.into_iter().find(|name| arg.get_env().is_some_and(|variable| variable == *name))
}

fn with_its_file(arg: Arg, name: &str) -> Arg {
    let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
    arg.help(format!("{help}; or in the file that {name}_FILE names"))
}

/// Returns the file that the environment names for an argument.
fn named<'a>(arg: &Arg, files: &'a [Named]) -> Option<&'a Named> {
    files.iter().find(|(name, _)| secret(arg) == Some(*name))
}

/// Returns the values from files for the given subcommand.
fn read(command: &Command, matches: &ArgMatches, files: &[Named]) -> Result<Vec<(&'static str, String)>, SecretError> {
    let (mut command, mut matches) = (command, matches);
    while let Some((name, below)) = matches.subcommand() {
        let Some(chosen) = command.find_subcommand(name) else { break };
        (command, matches) = (chosen, below);
    }
    let mut found = Vec::new();
    for arg in command.get_arguments() {
        let Some((name, file)) = named(arg, files) else { continue };
        match matches.value_source(arg.get_id().as_str()) {
            Some(ValueSource::CommandLine) => {}
            Some(ValueSource::EnvVariable) => return Err(SecretError::Both { name }),
            _ => {
                let unreadable = |source| SecretError::File { name, file: file.clone(), source };
                let text = fs::read_to_string(file).map_err(unreadable)?;
                found.push((*name, text.trim_end_matches(['\r', '\n']).to_owned()));
            }
        }
    }
    Ok(found)
}

/// Flags of arguments whose values help does not show.
fn hidden_flags(command: &Command) -> Vec<String> {
    let own = command.get_arguments().filter(|arg| arg.is_hide_env_values_set()).filter_map(Arg::get_long);
    let own = own.map(|long| format!("--{long}"));
    own.chain(command.get_subcommands().flat_map(hidden_flags)).collect()
}

/// Returns clap's message without values of such arguments and without user and password of URLs.
fn hide(mut error: clap::Error, hidden: &[String], arguments: &[OsString]) -> Refused {
    if let Some(ContextValue::String(arg)) = error.get(ContextKind::InvalidArg)
        && arg.split(' ').next().is_some_and(|flag| hidden.iter().any(|hidden| hidden == flag))
        && error.get(ContextKind::InvalidValue).is_some()
    {
        error.insert(ContextKind::InvalidValue, ContextValue::String(HIDDEN.to_owned()));
    }
    let said = error.render().to_string();
    let told = arguments.iter().map(|arg| arg.to_string_lossy()).fold(said.clone(), |told, arg| {
        let value = arg.strip_prefix("--").and_then(|flag| flag.split_once('=')).map_or(&*arg, |(_, value)| value);
        if value.contains('@') && value.contains(':') { told.replace(value, HIDDEN) } else { told }
    });
    if told == said { Refused::Said(error) } else { Refused::Hidden(told) }
}

#[cfg(test)]
mod tests {
    use std::{iter, path::Path};

    use clap::CommandFactory as _;

    use super::*;
    use crate::cli::Arguments;

    const CANARY: &str = "canary-2718281828";

    /// Returns the value of `id` of the given subcommand, if these variables name files.
    fn value(arguments: &[&str], files: &[(&str, &Path)], id: &str) -> Result<Option<String>, String> {
        let variable = |name: &str| {
            let file = files.iter().find(|(of, _)| name.strip_suffix("_FILE") == Some(*of));
            file.map(|(_, path)| path.as_os_str().to_owned())
        };
        let arguments = iter::once("flankfit").chain(arguments.iter().copied()).map(OsString::from);
        match matches(Arguments::command(), arguments, variable) {
            Ok(matches) => {
                let mut chosen = &matches;
                while let Some((_, below)) = chosen.subcommand() {
                    chosen = below;
                }
                Ok(chosen.get_raw(id).and_then(|mut all| all.next()).map(|raw| raw.to_string_lossy().into_owned()))
            }
            Err(Refused::Said(error)) => Err(error.render().to_string()),
            Err(Refused::Hidden(text)) => Err(text),
            Err(Refused::Secret(error)) => Err(error.to_string()),
        }
    }

    #[test]
    fn arguments_take_precedence_and_unused_files_are_not_read() {
        let missing = Path::new("/nowhere/url");
        let files = [("FLANKFIT_DATABASE_URL", missing)];
        let told = value(&["migrate", "--database-url", "postgres://h/d"], &files, "database_url");
        assert_eq!(told, Ok(Some("postgres://h/d".into())));
        assert!(value(&["openapi"], &files, "v3_0").is_ok());
        let refused = value(&["migrate"], &files, "database_url").unwrap_err();
        let start = "cannot read /nowhere/url, which FLANKFIT_DATABASE_URL_FILE names: ";
        assert!(refused.starts_with(start) && refused.lines().count() == 1, "{refused}");
        let required = value(&["migrate"], &[], "database_url").unwrap_err();
        assert!(required.contains("--database-url <DATABASE_URL>"), "{required}");
    }

    #[test]
    fn contents_of_secret_files_are_in_no_error() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("keys");
        let keys = [("FLANKFIT_API_KEYS_SHA256", file.as_path())];
        fs::write(&file, CANARY).unwrap();
        let refused = value(&["serve"], &keys, "api_keys_sha256").unwrap_err();
        assert!(!refused.contains(CANARY) && refused.contains("64 hexadecimal digits"), "{refused}");
        fs::write(&file, [CANARY.as_bytes(), &[0xff]].concat()).unwrap();
        let refused = value(&["serve"], &keys, "api_keys_sha256").unwrap_err();
        assert!(!refused.contains(CANARY) && refused.contains("FLANKFIT_API_KEYS_SHA256_FILE"), "{refused}");
    }

    #[test]
    fn help_shows_no_secret_values() {
        fn look(command: &Command, met: &mut usize) {
            for arg in command.get_arguments() {
                let variable = arg.get_env().unwrap_or_default().to_string_lossy();
                let is_url = ["_URL", "_ISSUER", "_ENDPOINT"].iter().any(|end| variable.ends_with(end));
                if secret(arg).is_some() || is_url {
                    assert!(arg.is_hide_env_values_set(), "{} {arg}", command.get_name());
                    *met += 1;
                }
            }
            command.get_subcommands().for_each(|below| look(below, met));
        }
        let mut met = 0;
        look(&Arguments::command(), &mut met);
        assert!(met > 20, "{met}");
    }
}
