//! `deny.toml` kept: licences, bans and sources of everything that the program is built from. Where
//! `cargo deny` is installed the gate asks it as well; this test has the same rules of the same
//! file and needs cargo alone.

use std::{collections::BTreeSet, fs, process::Command};

use serde_json::Value;

use super::root;

const CRATES_IO: &str = "registry+https://github.com/rust-lang/crates.io-index";

/// The strings between `open` and the next `close`.
fn strings_between(text: &str, open: &str, close: &str) -> Vec<String> {
    let from = text.find(open).unwrap_or_else(|| panic!("deny.toml has no {open:?}")) + open.len();
    let inside = &text[from..from + text[from..].find(close).expect("it ends")];
    inside.split('"').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Content of `deny.toml`.
struct Rules {
    targets: Vec<String>,
    licences: Vec<String>,
    /// With those that may build on them all the same.
    banned: Vec<(String, Vec<String>)>,
}

impl Rules {
    fn read() -> Self {
        let text = fs::read_to_string(root().join("deny.toml")).expect("deny.toml");
        for rule in [r#"wildcards = "deny""#, r#"unknown-registry = "deny""#, r#"unknown-git = "deny""#] {
            assert!(text.contains(rule), "deny.toml without {rule}, which this test keeps");
        }
        let bans = &text[text.find("\ndeny = [").expect("bans")..text.find("[sources]").expect("sources")];
        let banned = bans.lines().filter(|line| line.contains("name = ")).map(|line| {
            let wrappers =
                if line.contains("wrappers") { strings_between(line, "wrappers = [", "]") } else { Vec::new() };
            (strings_between(line, "name = ", ",").remove(0), wrappers)
        });
        Rules {
            targets: strings_between(&text, "targets = [", "]"),
            licences: strings_between(&text, "\nallow = [", "]"),
            banned: banned.collect(),
        }
    }
}

/// True if an SPDX expression can be met by licences that are allowed. `A/B` is what `A OR B` was
/// before.
fn allowed(expression: &str, licences: &[String]) -> bool {
    let spaced = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let tokens: Vec<&str> = spaced.split_whitespace().collect();
    let mut at = 0;
    let met = any_of(&tokens, &mut at, licences);
    met && at == tokens.len()
}

fn any_of(tokens: &[&str], at: &mut usize, licences: &[String]) -> bool {
    let mut met = all_of(tokens, at, licences);
    while tokens.get(*at) == Some(&"OR") {
        *at += 1;
        met |= all_of(tokens, at, licences);
    }
    met
}

fn all_of(tokens: &[&str], at: &mut usize, licences: &[String]) -> bool {
    let mut met = one(tokens, at, licences);
    while tokens.get(*at) == Some(&"AND") {
        *at += 1;
        met &= one(tokens, at, licences);
    }
    met
}

fn one(tokens: &[&str], at: &mut usize, licences: &[String]) -> bool {
    let Some(&token) = tokens.get(*at) else { return false };
    *at += 1;
    if token == "(" {
        let met = any_of(tokens, at, licences);
        *at += 1;
        return met;
    }
    let mut name = token.to_owned();
    if tokens.get(*at) == Some(&"WITH") {
        name = format!("{token} WITH {}", tokens.get(*at + 1).copied().unwrap_or_default());
        *at += 2;
    }
    licences.contains(&name)
}

fn cargo(arguments: &[&str]) -> String {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    let output = cargo.args(arguments).arg("--locked").current_dir(root()).output().expect("cargo can be started");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("cargo writes text")
}

/// The packages that a target is built from, development included. Metadata alone would name some
/// that no enabled feature needs.
fn packages(target: &str) -> Vec<Value> {
    let tree = cargo(&["tree", "--workspace", "--target", target, "--prefix", "none", "--format", "{p}"]);
    let used: BTreeSet<String> = tree
        .lines()
        .filter(|line| !line.is_empty())
        .map(|line| line.split(' ').take(2).collect::<Vec<_>>().join(" "))
        .collect();
    let metadata = cargo(&["metadata", "--format-version", "1", "--filter-platform", target]);
    let metadata: Value = serde_json::from_str(&metadata).expect("cargo writes JSON");
    let all = metadata["packages"].as_array().expect("packages");
    let is_used = |package: &&Value| {
        let part = |name: &str| package[name].as_str().unwrap_or_default().to_owned();
        used.contains(&format!("{} v{}", part("name"), part("version")))
    };
    let found: Vec<Value> = all.iter().filter(is_used).cloned().collect();
    assert_eq!(found.len(), used.len(), "every package of the tree is described");
    found
}

/// The packages that have one among their own dependencies.
fn who_builds_on(name: &str, target: &str) -> Vec<String> {
    let format = ["--depth", "1", "--prefix", "none", "--format", "{p}"];
    let tree = cargo(&[&["tree", "--workspace", "--target", target, "--invert", name], &format[..]].concat());
    let names = tree.lines().skip(1).filter_map(|line| line.split(' ').next());
    names.filter(|user| !user.is_empty()).map(str::to_owned).collect()
}

#[test]
fn licences_bans_and_sources_are_those_of_deny_toml() {
    let rules = Rules::read();
    assert!(!rules.targets.is_empty() && !rules.licences.is_empty() && !rules.banned.is_empty());
    let mut wrong = BTreeSet::new();
    for target in &rules.targets {
        for package in packages(target) {
            let name = package["name"].as_str().expect("a name");
            let licence = package["license"].as_str().unwrap_or("none");
            if !allowed(licence, &rules.licences) {
                wrong.insert(format!("{name}: licence {licence}"));
            }
            if let Some((_, wrappers)) = rules.banned.iter().find(|(banned, _)| banned == name) {
                let others: Vec<String> =
                    who_builds_on(name, target).into_iter().filter(|user| !wrappers.contains(user)).collect();
                if wrappers.is_empty() || !others.is_empty() {
                    wrong.insert(format!("{name} is banned: {others:?} build on it"));
                }
            }
            match package["source"].as_str() {
                Some(CRATES_IO) => {}
                Some(other) => _ = wrong.insert(format!("{name} comes from {other}")),
                None => {
                    let needed = package["dependencies"].as_array().expect("dependencies");
                    // A path is a version of its own.
                    let any = |needed: &&Value| needed["req"] == "*" && needed["path"].is_null();
                    wrong.extend(needed.iter().filter(any).map(|d| format!("{name} takes any {}", d["name"])));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn licence_expressions_are_read() {
    let licences: Vec<String> = ["MIT", "Apache-2.0", "Zlib"].map(str::to_owned).into();
    let met = ["MIT", "MIT OR GPL-3.0", "GPL-3.0/MIT", "(MIT OR GPL-3.0) AND Zlib", "GPL-3.0 AND MIT OR Zlib"];
    for expression in met {
        assert!(allowed(expression, &licences), "{expression}");
    }
    let unmet =
        ["GPL-3.0", "MIT AND GPL-3.0", "Apache-2.0 WITH LLVM-exception", "(MIT OR Zlib) AND GPL-3.0", "", "none"];
    for expression in unmet {
        assert!(!allowed(expression, &licences), "{expression}");
    }
}
