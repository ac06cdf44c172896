//! The program, run to its end by the command line.

use std::process::Command;

/// Exit code, standard output and standard error of the program, with no variables but these.
pub fn program(arguments: &[&str], environment: &[(&str, &str)]) -> (Option<i32>, String, String) {
    let run = Command::new(env!("CARGO_BIN_EXE_flankfit"))
        .args(arguments)
        .env_clear()
        .envs(environment.iter().copied())
        .output()
        .unwrap();
    let [out, err] = [run.stdout, run.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    (run.status.code(), out, err)
}
