//! Reads the sources: which module of the service imports which, where SQL is written, what a clone
//! needs. Between the crates the compiler keeps the directions.

mod dependencies;
mod links;
mod prose;
mod secrets;
mod settings;
mod sizes;

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

/// A module of the service, the others that it may import, and the crates that it must not use.
struct Rule {
    module: &'static str,
    imports: &'static [&'static str],
    foreign: &'static [&'static str],
}

/// The only crates that the engine builds on: none that reads a socket, a clock or a file.
const ENGINE_BUILDS_ON: &[&str] = &[
    "libm",
    "miniz_oxide",
    "nalgebra",
    "num-traits",
    "quick-xml",
    "rand_chacha",
    "rayon",
    "serde",
    "serde_json",
    "serde_with_macros",
    "thiserror",
    "utoipa",
];

const ENGINE: &[&str] =
    &["engine", "engine/estimation", "engine/formats", "engine/gear", "engine/geometry", "engine/numerics"];

/// Every module may write to telemetry, as to a log.
const RULES: &[Rule] = &[
    Rule {
        module: "api",
        imports: &["jobs", "telemetry"],
        foreign: &["axum", "clap", "metrics", "sqlx", "tokio", "tower", "tower_http", "utoipa_axum"],
    },
    Rule {
        module: "jobs",
        imports: &["telemetry"],
        foreign: &["axum", "clap", "metrics", "sqlx", "tower", "tower_http", "utoipa_axum"],
    },
    Rule {
        module: "store",
        imports: &["jobs", "telemetry"],
        foreign: &["axum", "clap", "tower", "tower_http", "utoipa", "utoipa_axum"],
    },
    Rule {
        module: "http",
        imports: &["api", "jobs", "oidc", "pool", "config", "telemetry", "usecases"],
        foreign: &["clap", "sqlx"],
    },
    Rule {
        module: "usecases",
        imports: &["api", "jobs", "pool", "telemetry"],
        foreign: &["axum", "clap", "sqlx", "tower", "tower_http", "utoipa", "utoipa_axum"],
    },
    Rule {
        module: "oidc",
        imports: &["config", "jobs", "outgoing", "telemetry"],
        foreign: &["axum", "clap", "metrics", "sqlx", "utoipa"],
    },
    Rule { module: "pool", imports: &["telemetry"], foreign: &["axum", "clap", "sqlx", "utoipa"] },
    Rule { module: "outgoing", imports: &[], foreign: &["axum", "clap", "sqlx", "tokio", "utoipa"] },
    Rule { module: "telemetry", imports: &["config", "outgoing"], foreign: &["axum", "clap", "sqlx", "utoipa"] },
    Rule { module: "config", imports: &[], foreign: &["axum", "sqlx", "utoipa"] },
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every source file of the engine and of the service.
fn sources() -> Vec<PathBuf> {
    ENGINE.iter().chain(&["."]).flat_map(|folder| rust_files(&root().join(folder).join("src"))).collect()
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    files(folder, &["rs"])
}

/// The files with one of these extensions in a folder and below.
fn files(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let Ok(entries) = fs::read_dir(folder) else { return found };
    for entry in entries.map(|e| e.expect("a folder entry").path()) {
        if entry.is_dir() {
            found.extend(files(&entry, extensions));
        } else if entry.extension().is_some_and(|e| extensions.iter().any(|one| e == *one)) {
            found.push(entry);
        }
    }
    found.sort();
    found
}

/// The formatted source without lines of comments.
fn code(file: &Path) -> String {
    let text = fs::read_to_string(file).expect("a source file");
    text.lines().filter(|line| !line.trim_start().starts_with("//")).flat_map(|line| [line, "\n"]).collect()
}

/// The names that follow `prefix`, those of a group `{…}` included.
fn heads<'a>(code: &'a str, prefix: &str) -> BTreeSet<&'a str> {
    let name = |text: &'a str| text.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default();
    let mut found = BTreeSet::new();
    for (at, _) in code.match_indices(prefix) {
        let rest = &code[at + prefix.len()..];
        let Some(group) = rest.strip_prefix('{') else {
            found.insert(name(rest));
            continue;
        };
        let mut depth = 0_i32;
        let mut begins = true;
        for (k, c) in group.char_indices() {
            if begins && c.is_alphabetic() {
                found.insert(name(&group[k..]));
            }
            begins = (begins && c.is_whitespace()) || (c == ',' && depth == 0);
            depth += i32::from(c == '{') - i32::from(c == '}');
            if depth < 0 {
                break;
            }
        }
    }
    found
}

#[test]
fn imports_point_downwards() {
    let src = root().join("src");
    let entries = fs::read_dir(&src).expect("sources").map(|entry| entry.expect("an entry").path());
    let modules: Vec<String> =
        entries.map(|path| path.file_stem().expect("a name").to_string_lossy().into_owned()).collect();
    let mut wrong = Vec::new();
    let mut imports = 0;
    for Rule { module, imports: allowed, foreign } in RULES {
        let mut files = rust_files(&src.join(module));
        files.extend(Some(src.join(format!("{module}.rs"))).filter(|file| file.exists()));
        assert!(!files.is_empty(), "there is no {module}");
        for file in files {
            let code = code(&file);
            for used in heads(&code, "crate::") {
                imports += 1;
                if modules.iter().any(|known| known == used) && used != *module && !allowed.contains(&used) {
                    wrong.push(format!("{} imports crate::{used}", file.display()));
                }
            }
            for name in *foreign {
                if heads(&code, "use ").contains(name) || code.contains(&format!(" {name}::")) {
                    wrong.push(format!("{} uses the crate {name}", file.display()));
                }
            }
        }
    }
    assert!(wrong.is_empty() && imports > 400, "{imports} imports\n{}", wrong.join("\n"));
}

#[test]
fn heads_of_paths_are_found() {
    let code = "use crate::{\n    estimation::{fit, Nodes},\n    http,\n};\nlet x = crate::store::x();\n";
    assert_eq!(heads(code, "crate::"), BTreeSet::from(["estimation", "http", "store"]));
}

#[test]
fn the_engine_builds_on_mathematics_only() {
    let mut names = BTreeSet::new();
    for folder in ENGINE {
        let manifest = fs::read_to_string(root().join(folder).join("Cargo.toml")).expect("a manifest");
        let table = manifest.split("[dependencies]").nth(1).and_then(|rest| rest.split("\n[").next()).expect("a table");
        let lines = table.lines().filter(|line| !line.starts_with('#') && !line.starts_with("flankfit-"));
        names.extend(lines.filter_map(|line| line.split(['.', ' ']).next()).map(str::to_owned));
    }
    names.remove("");
    assert!(names.iter().eq(ENGINE_BUILDS_ON), "{names:?}");
}

#[test]
fn sql_stays_in_the_store() {
    const HEADS: [&str; 12] = [
        "SELECT ",
        "INSERT INTO ",
        "INSERT OR ",
        "UPDATE ",
        "DELETE FROM ",
        "CREATE TABLE ",
        "CREATE INDEX ",
        "DROP ",
        "ALTER TABLE ",
        "PRAGMA ",
        "BEGIN IMMEDIATE",
        "VACUUM ",
    ];
    let store = root().join("src/store");
    for file in sources().into_iter().filter(|file| !file.starts_with(&store)) {
        let code = code(&file);
        for text in code.split('"') {
            let start = text.trim_start();
            assert!(!HEADS.iter().any(|head| start.starts_with(head)), "{}: {start:?}", file.display());
        }
    }
}

/// A clone is whole: what tests, examples, benches and tools read is in it.
#[test]
fn nothing_outside_the_project_is_needed() {
    let folders = ["engine", "src", "tests", "examples", "benches", "fuzz/fuzz_targets"];
    for file in folders.iter().flat_map(|folder| rust_files(&root().join(folder))) {
        for text in code(&file).split('"').filter(|text| text.starts_with("../")) {
            assert!(file.parent().expect("a folder").join(text).exists(), "{}: {text:?}", file.display());
        }
    }
}
