//! Running programs at the root of the repository.

use std::{
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

/// Result whose error is a message for a person.
pub(crate) type Outcome<T = ()> = Result<T, String>;

/// The root of the repository.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies below the root")
}

/// Cargo, the one that runs this.
pub(crate) fn cargo() -> Command {
    program(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// A program, to be run at the root.
pub(crate) fn program(name: impl AsRef<std::ffi::OsStr>) -> Command {
    let mut command = Command::new(name);
    command.current_dir(root());
    command
}

/// Runs it, with its output where ours goes.
pub(crate) fn run(command: &mut Command) -> Outcome {
    eprintln!("+ {command:?}");
    let status = command.status().map_err(|error| format!("{command:?}: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("{command:?} failed ({status})")) }
}

/// Standard output of the command.
pub(crate) fn output(command: &mut Command) -> Outcome<Vec<u8>> {
    let output = command.stderr(Stdio::inherit()).output().map_err(|error| format!("{command:?}: {error}"))?;
    if output.status.success() { Ok(output.stdout) } else { Err(format!("{command:?} failed ({})", output.status)) }
}

/// Fails unless there is a `cargo NAME`, with the command that installs it.
pub(crate) fn needs_cargo(subcommand: &str) -> Outcome {
    let asked = cargo().args([subcommand, "--version"]).stdout(Stdio::null()).stderr(Stdio::null()).status();
    let there = asked.is_ok_and(|status| status.success());
    if there { Ok(()) } else { Err(format!("not installed: cargo install --locked cargo-{subcommand}")) }
}

/// The Python of a virtual environment under `target/` that has the packages of
/// `tools/requirements.txt`.
pub(crate) fn python() -> Outcome<PathBuf> {
    let folder = root().join("target/tools-venv");
    let (python, ready) = (folder.join("bin/python"), folder.join("ready"));
    if !ready.exists() {
        run(program("python3").args(["-m", "venv"]).arg(&folder))?;
        run(program(&python).args(["-m", "pip", "install", "--quiet", "-r", "tools/requirements.txt"]))?;
        std::fs::write(&ready, "").map_err(|error| format!("{}: {error}", ready.display()))?;
    }
    Ok(python)
}
