//! Runs every command of `docs/how-to/plant.md`, in its order.

use std::{
    fs,
    os::unix::{fs::chown, process::CommandExt},
    path::Path,
    process::Stdio,
};

use super::proxy::{configuration, free_address};
use crate::postgres::shell;

/// Ends what is left when a command has failed.
const PREAMBLE: &str = "set -eu
trap 'exit 1' TERM
trap 'cd \"$PLANT_FOLDER\"; kill -9 $(cat *.pid) || true; pg_ctl -D data -m immediate stop || true' EXIT
";
/// End of the script in which all servers have ended by themselves.
const END: &str = "trap - EXIT\n";
/// The user of the tests' servers where tests run as root.
const NOBODY: u32 = 65534;

/// Commands in the document's shell blocks.
fn commands(document: &str) -> String {
    let blocks = document.split("```sh\n").skip(1).map(|rest| rest.split("```").next().unwrap());
    blocks.collect()
}

#[test]
#[cfg_attr(
    any(without_postgres, without_haproxy, without_openssl),
    ignore = "there is no PostgreSQL server, no haproxy or no openssl"
)]
fn the_commands_of_the_document_lead_to_a_plant() {
    let document = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/how-to/plant.md")).unwrap();
    let commands = commands(&document);
    let folder = tempfile::Builder::new().prefix("ff").tempdir().unwrap();
    // the user of the commands may read these, wherever the project is
    let programs = folder.path().join("programs");
    fs::create_dir(&programs).unwrap();
    fs::copy(env!("CARGO_BIN_EXE_flankfit"), programs.join("flankfit")).unwrap();
    fs::copy(configuration(), programs.join("haproxy.cfg")).unwrap();
    fs::write(programs.join("commands"), format!("{PREAMBLE}{commands}{END}")).unwrap();
    // where the tests do not run as root, they are this user's
    let _refused = chown(folder.path(), Some(NOBODY), Some(NOBODY));
    let errors = fs::File::create(folder.path().join("errors")).unwrap();
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap());
    let run = shell(folder.path(), "PATH=\"$PATH:$BIN\" exec timeout 300 sh programs/commands")
        .env("PATH", path)
        .env("HOME", folder.path())
        .env("PLANT_CONFIGURATION", programs.join("haproxy.cfg"))
        .env("PLANT_POSTGRES", free_address().port().to_string())
        .envs(["PLANT_LISTEN", "PLANT_ONE", "PLANT_TWO", "PLANT_THREE"].map(|name| (name, free_address().to_string())))
        .stdout(Stdio::piped())
        .stderr(errors)
        .process_group(0)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stdout);
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap_or_default();
    let logs = ["errors", "plant/one.log", "plant/haproxy.log", "plant/postgres.log"].map(read).join("\n");
    assert!(run.status.success(), "{said}\n{logs}");
    let numbers: Vec<&str> = said.lines().filter(|line| line.starts_with("\"number\":")).collect();
    // the first is requested twice
    let expected = [1, 1, 2, 3, 4].map(|number| format!("\"number\":{number}"));
    assert_eq!(numbers, expected);
    for number in expected {
        assert!(document.contains(&number) || number.ends_with('4'), "{number} is documented");
    }
    let secret = read("plant/key");
    assert!(secret.trim().len() == 64 && !logs.contains(secret.trim()), "no secret is in a log");
    assert!(!logs.contains(read("plant/app.password").trim()), "nor a password");
}
