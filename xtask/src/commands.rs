//! One function for each command, and the table that names them.

use std::fs;

use crate::shell::{Outcome, cargo, needs_cargo, output, program, python, root, run};

/// Name, arguments, what it does, and the function.
type Entry = (&'static str, &'static str, &'static str, fn(&[String]) -> Outcome);

const COMMANDS: &[Entry] = &[
    ("ci", "", "everything that must hold before a change is taken (.ci/run)", ci),
    ("openapi", "", "write openapi/flankfit.json from the code", openapi),
    ("bench", "[NAME] [OPTION…]", "benches whose name contains NAME; `service` is those over HTTP", bench),
    ("fuzz", "TARGET [OPTION…]", "a reader of gear files under a fuzzer (fuzz/README.md)", fuzz),
    ("schemathesis", "[OPTION…]", "the service against its own contract", schemathesis),
    ("clients", "", "clients generated, compiled and run (docs/how-to/clients.md)", clients),
    ("cad", "", "exported IGES and STEP files, opened with OpenCASCADE", cad),
    ("scipy", "", "surfaces beside scipy's: numbers and time", scipy),
    ("figures", "", "draw the figures of docs/ anew", figures),
    ("memory", "[OPTION…]", "what a server can be made to hold (tools/memory_attack.py)", memory),
    ("deny", "", "licences, bans, sources and advisories by cargo deny", deny),
    ("semver", "[REVISION]", "what breaks callers of the engine since REVISION (main)", semver),
    ("portability", "", "check the engine for other processors, compare digits without flags", portability),
];

/// The list of commands.
pub(crate) fn help() -> String {
    let line = |(name, arguments, what, _): &Entry| format!("  {:<28} {what}\n", format!("{name} {arguments}"));
    format!("cargo xtask COMMAND\n\n{}", COMMANDS.iter().map(line).collect::<String>())
}

/// Runs the command of that name.
pub(crate) fn run_command(name: &str, arguments: &[String]) -> Outcome {
    match COMMANDS.iter().find(|entry| entry.0 == name) {
        Some((_, _, _, function)) => function(arguments),
        None => Err(format!("there is no such command\n\n{}", help())),
    }
}

fn ci(_: &[String]) -> Outcome {
    run(&mut program(".ci/run"))
}

fn openapi(_: &[String]) -> Outcome {
    let mut flankfit = cargo();
    flankfit.args(["run", "--quiet", "--locked", "--profile", "test", "--bin", "flankfit", "--", "openapi"]);
    let path = root().join("openapi/flankfit.json");
    fs::write(&path, output(&mut flankfit)?).map_err(|error| format!("{}: {error}", path.display()))
}

fn bench(arguments: &[String]) -> Outcome {
    let (package, arguments) = match arguments.split_first() {
        Some((first, rest)) if first == "service" => ("service-benches", rest),
        _ => ("engine-benches", arguments),
    };
    run(cargo().args(["bench", "--locked", "-p", package, "--"]).args(arguments))
}

fn fuzz(arguments: &[String]) -> Outcome {
    needs_cargo("fuzz")?;
    let (target, options) = arguments.split_first().ok_or("which target? (fuzz/README.md)")?;
    let mut fuzz = program("cargo");
    fuzz.args(["+nightly", "fuzz", "run", target, "--", "-dict=fuzz/gear_files.dict", "-max_total_time=600"]);
    run(fuzz.args(options))
}

fn schemathesis(arguments: &[String]) -> Outcome {
    run(program(".ci/schemathesis").args(arguments))
}

fn clients(_: &[String]) -> Outcome {
    run(&mut program("clients/run"))
}

fn cad(_: &[String]) -> Outcome {
    run(cargo().args(["run", "--locked", "-p", "engine-benches", "--example", "export_cad", "--", "target/cad"]))?;
    run(program(python()?).args(["tools/check_cad.py", "target/cad"]))
}

fn scipy(_: &[String]) -> Outcome {
    run(program(python()?).arg("tools/compare_scipy.py"))
}

fn figures(_: &[String]) -> Outcome {
    run(program("python3").arg("tools/draw_machine_settings.py"))
}

fn memory(arguments: &[String]) -> Outcome {
    run(cargo().args(["build", "--locked", "--release", "--bin", "flankfit"]))?;
    run(program("tools/memory_attack.py").arg("target/release/flankfit").args(arguments))
}

fn deny(_: &[String]) -> Outcome {
    needs_cargo("deny")?;
    run(cargo().args(["deny", "--locked", "check", "licenses", "bans", "sources"]))?;
    // The database of advisories comes from the network.
    run(cargo().args(["deny", "--locked", "check", "advisories"]))
}

fn semver(arguments: &[String]) -> Outcome {
    needs_cargo("semver-checks")?;
    let revision = arguments.first().map_or("main", String::as_str);
    run(cargo().args(["semver-checks", "-p", "flankfit-engine", "--baseline-rev", revision]))
}

/// Processors that the engine is checked for, where their standard library is installed.
const TARGETS: &[&str] = &["x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu", "aarch64-apple-darwin"];

fn portability(_: &[String]) -> Outcome {
    let installed = output(program("rustup").args(["target", "list", "--installed"]))?;
    let installed = String::from_utf8_lossy(&installed).into_owned();
    for target in TARGETS {
        if !installed.lines().any(|line| line == *target) {
            println!("{target}: not checked (rustup target add {target})");
            continue;
        }
        let mut check = cargo();
        // Without the flags of .cargo/config.toml, as those build who use the engine as a crate.
        check.env("RUSTFLAGS", "").args(["check", "--locked", "-p", "flankfit-engine", "--target", target]);
        run(&mut check)?;
        println!("{target}: checked");
    }
    same_digits()
}

/// Builds the same work with and without the flags of .cargo/config.toml and compares every digit.
fn same_digits() -> Outcome {
    let rows = |flags: Option<&str>| {
        let mut work = cargo();
        work.args(["run", "--quiet", "--locked", "-p", "engine-benches", "--example", "portable"]);
        output(work.envs(flags.map(|flags| ("RUSTFLAGS", flags))))
    };
    let (with, without) = (rows(None)?, rows(Some(""))?);
    let rows = String::from_utf8_lossy(&with).into_owned();
    match rows.lines().zip(String::from_utf8_lossy(&without).lines()).find(|(a, b)| a != b) {
        Some((with, without)) => Err(format!("with flags:    {with}\nwithout flags: {without}")),
        None if with != without || rows.is_empty() => Err("the builds did different work".into()),
        None => {
            println!("{} kinds of work: the same digits with and without flags", rows.lines().count());
            Ok(())
        }
    }
}
