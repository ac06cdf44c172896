//! The table of settings in `docs/reference/operation.md` against those of the program.

use std::{collections::BTreeMap, fs};

use clap::{Arg, ArgAction, Args as _, Command};
use flankfit::config::ServeSettings;

use crate::root;

/// Words of the table for a missing default.
const NONE: [&str; 7] = ["none", "–", "never", "by the issuer", "those of browsers", "as `--rate-limit`", "see below"];

/// Variable and default of each flag.
type Settings = BTreeMap<String, (String, Option<String>)>;

fn command() -> Command {
    ServeSettings::augment_args(Command::new("serve"))
}

fn of_program() -> Settings {
    let setting = |arg: &Arg| {
        let flag = arg.get_long().expect("a flag");
        let variable = arg.get_env().expect("a variable").to_string_lossy().into_owned();
        let default = match arg.get_action() {
            ArgAction::SetTrue => Some("off".to_owned()),
            _ => arg.get_default_values().first().map(|default| default.to_string_lossy().into_owned()),
        };
        // an empty list is none
        (format!("--{flag}"), (variable, default.filter(|default| !default.is_empty())))
    };
    let command = command();
    command.get_arguments().map(setting).collect()
}

fn of_document() -> Settings {
    let text = fs::read_to_string(root().join("docs/reference/operation.md")).expect("the document");
    let section = text.split("\n## ").find(|section| section.starts_with("Settings\n")).expect("the section");
    let names =
        |cell: &str| -> Vec<String> { cell.split(", ").map(|name| name.trim().trim_matches('`').to_owned()).collect() };
    let mut settings = Settings::new();
    for line in section.lines().filter(|line| line.starts_with("| `--")) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let (flags, variables) = (names(cells[0]), names(cells[1]));
        assert_eq!(flags.len(), variables.len(), "{line}");
        // a default may be followed by what it means
        let value = cells[2].split(" (").next().unwrap_or_default().trim_matches('`');
        let default = (!NONE.contains(&cells[2])).then(|| value.to_owned());
        for (flag, variable) in flags.into_iter().zip(variables) {
            assert!(settings.insert(flag, (variable, default.clone())).is_none(), "{line}");
        }
    }
    settings
}

#[test]
fn the_document_names_every_setting_with_its_variable_and_default() {
    let (program, document) = (of_program(), of_document());
    assert!(program.len() > 40, "only {} settings were found", program.len());
    let differing = |these: &Settings, those: &Settings| -> Vec<String> {
        let differ = these.iter().filter(|(flag, setting)| those.get(*flag) != Some(*setting));
        differ.map(|(flag, (variable, default))| format!("{flag} {variable} {default:?}")).collect()
    };
    assert_eq!(differing(&program, &document), differing(&document, &program));
    assert_eq!(program, document);
}

/// Defaults that are documented for operators and used for sizing.
#[test]
fn defaults_of_a_plant_stay() {
    let program = of_program();
    for (flag, default) in [
        ("--store-writers", "4"),
        ("--database-readers", "8"),
        ("--store-patience", "5"),
        ("--migrate", "auto"),
        ("--auth", "auto"),
        ("--api-keys-role", "engineer"),
        ("--max-connections", "4096"),
        ("--body-memory", "805306368"),
        ("--write-timeout", "30"),
        ("--progress-timeout", "3600"),
        ("--tls-client-auth", "off"),
        ("--drain-delay", "0"),
        ("--audit-seal-seconds", "10"),
        ("--otlp-sample", "0.01"),
    ] {
        assert_eq!(program[flag].1.as_deref(), Some(default), "{flag}");
    }
    for flag in ["--rate-limit", "--rate-burst", "--tls-cert", "--tls-key", "--tls-client-ca", "--ops-bind"] {
        assert_eq!(program[flag].1, None, "{flag}");
    }
    for flag in ["--trusted-proxies", "--otlp-endpoint"] {
        assert_eq!(program[flag].1, None, "{flag}");
    }
}
