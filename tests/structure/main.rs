//! Which room may know which: reads the sources and enforces the directions that ARCHITECTURE.md
//! draws. Between the engine and the service the compiler sees to it; here are the directions
//! inside of each.

mod circles;
mod dependencies;
mod secrets;
mod settings;
mod sizes;

use std::fs;
use std::path::{Path, PathBuf};

/// A room under `src/`, the rooms it may import, and the crates it must not know.
struct Rule {
    room: &'static str,
    rooms: &'static [&'static str],
    foreign: &'static [&'static str],
}

/// Rooms of the engine's crate; all others are the service's.
const ENGINE: &[&str] = &["estimation", "fault", "formats", "gear", "geometry", "numerics"];

/// The only crates that the engine builds on: none that knows a wire, a clock or a file.
const ENGINE_BUILDS_ON: &[&str] =
    &["libm", "miniz_oxide", "nalgebra", "num-traits", "quick-xml", "rand_chacha", "rayon", "thiserror"];

/// Telemetry, like a log, may be written to from every room above the mathematics.
const RULES: &[Rule] = &[
    Rule { room: "fault", rooms: &[], foreign: &[] },
    Rule { room: "numerics", rooms: &[], foreign: &[] },
    Rule { room: "geometry", rooms: &["fault", "numerics"], foreign: &[] },
    Rule { room: "formats", rooms: &["estimation", "fault", "gear", "geometry", "numerics"], foreign: &[] },
    Rule { room: "estimation", rooms: &["fault", "geometry", "numerics"], foreign: &[] },
    Rule { room: "gear", rooms: &["estimation", "fault", "geometry", "numerics"], foreign: &[] },
    Rule {
        room: "api",
        rooms: &["estimation", "fault", "formats", "gear", "geometry", "jobs", "numerics", "telemetry"],
        foreign: &["axum", "clap", "metrics", "sqlx", "tokio", "tower", "tower_http", "utoipa_axum"],
    },
    Rule {
        room: "jobs",
        rooms: &["estimation", "gear", "telemetry"],
        foreign: &["axum", "clap", "metrics", "sqlx", "tower", "tower_http", "utoipa", "utoipa_axum"],
    },
    Rule {
        room: "store",
        rooms: &["jobs", "estimation", "gear", "telemetry"],
        foreign: &["axum", "clap", "tower", "tower_http", "utoipa", "utoipa_axum"],
    },
    Rule {
        room: "http",
        rooms: &["api", "jobs", "estimation", "oidc", "pool", "config", "telemetry"],
        foreign: &["clap", "sqlx"],
    },
    Rule {
        room: "oidc",
        rooms: &["config", "jobs", "outgoing", "telemetry"],
        foreign: &["axum", "clap", "metrics", "sqlx", "utoipa"],
    },
    Rule { room: "pool", rooms: &["numerics", "telemetry"], foreign: &["axum", "clap", "sqlx", "utoipa"] },
    Rule { room: "outgoing", rooms: &[], foreign: &["axum", "clap", "sqlx", "tokio", "utoipa"] },
    Rule { room: "telemetry", rooms: &["config", "outgoing"], foreign: &["axum", "clap", "sqlx", "utoipa"] },
    Rule { room: "config", rooms: &[], foreign: &["axum", "sqlx", "utoipa"] },
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The `src/` in which a room lies.
fn source_of(room: &str) -> PathBuf {
    root().join(if ENGINE.contains(&room) { "engine/src" } else { "src" })
}

/// Every source file of the engine and of the service.
fn sources() -> Vec<PathBuf> {
    ["engine/src", "src"].iter().flat_map(|folder| rust_files(&root().join(folder))).collect()
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let Ok(entries) = fs::read_dir(folder) else { return files };
    for entry in entries.map(|e| e.expect("a folder entry").path()) {
        if entry.is_dir() {
            files.extend(rust_files(&entry));
        } else if entry.extension().is_some_and(|e| e == "rs") {
            files.push(entry);
        }
    }
    files.sort();
    files
}

/// The source split into code and the insides of its string literals; comments are dropped.
fn split(text: &str) -> (String, Vec<String>) {
    let (mut code, mut strings) = (String::new(), Vec::new());
    let chars: Vec<char> = text.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let mut i = 0;
    while i < chars.len() {
        let raw = at(i) == 'r' && (at(i + 1) == '"' || (at(i + 1) == '#' && matches!(at(i + 2), '"' | '#')));
        if at(i) == '/' && at(i + 1) == '/' {
            while i < chars.len() && at(i) != '\n' {
                i += 1;
            }
        } else if at(i) == '/' && at(i + 1) == '*' {
            let mut depth = 0;
            loop {
                match (at(i), at(i + 1)) {
                    ('/', '*') => (depth, i) = (depth + 1, i + 2),
                    ('*', '/') => (depth, i) = (depth - 1, i + 2),
                    _ => i += 1,
                }
                if depth == 0 || i >= chars.len() {
                    break;
                }
            }
        } else if raw && !at(i.wrapping_sub(1)).is_alphanumeric() {
            let hashes = (i + 1..).take_while(|k| at(*k) == '#').count();
            let start = i + 2 + hashes;
            let ends = |k: usize| at(k) == '"' && (1..=hashes).all(|h| at(k + h) == '#');
            let end = (start..chars.len()).find(|k| ends(*k)).unwrap_or(chars.len());
            strings.push(chars[start.min(end)..end].iter().collect());
            i = end + 1 + hashes;
        } else if at(i) == '"' {
            let mut inside = String::new();
            i += 1;
            while i < chars.len() && at(i) != '"' {
                if at(i) == '\\' {
                    i += 1;
                }
                inside.push(at(i));
                i += 1;
            }
            strings.push(inside);
            i += 1;
        } else if at(i) == '\'' && (at(i + 2) == '\'' || at(i + 1) == '\\') {
            // A character, not a lifetime.
            i += if at(i + 1) == '\\' { 3 } else { 2 };
            while i < chars.len() && at(i) != '\'' {
                i += 1;
            }
            i += usize::from(at(i) == '\'');
        } else {
            code.push(at(i));
            i += 1;
        }
    }
    (code, strings)
}

/// Identifiers and punctuation, in order.
fn tokens(code: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let mut word = String::new();
    for c in code.chars() {
        if c.is_alphanumeric() || c == '_' {
            word.push(c);
            continue;
        }
        if !word.is_empty() {
            tokens.push(std::mem::take(&mut word));
        }
        if !c.is_whitespace() {
            tokens.push(c.to_string());
        }
    }
    tokens.push(word);
    tokens
}

/// The names that follow the path prefix ending just before `start`: one name, or those of a `{…}`
/// group.
fn heads(tokens: &[String], start: usize) -> Vec<String> {
    if tokens.get(start).is_none_or(|t| t != "{") {
        return tokens.get(start).cloned().into_iter().collect();
    }
    let (mut names, mut depth, mut fresh) = (Vec::new(), 0, false);
    for token in &tokens[start..] {
        match token.as_str() {
            "{" => (depth, fresh) = (depth + 1, depth == 0),
            "}" => depth -= 1,
            "," => fresh = depth == 1,
            name if fresh && depth == 1 => {
                names.push(name.to_string());
                fresh = false;
            }
            _ => fresh = false,
        }
        if depth == 0 {
            break;
        }
    }
    names
}

/// Rooms named by `crate::…`, by `flankfit_engine::…` or by a chain of `super::` that climbs to the
/// crate root from a module `depth` rooms deep.
fn rooms_used(tokens: &[String], depth: usize) -> Vec<String> {
    let path = |i: usize| tokens.get(i).is_some_and(|t| t == ":") && tokens.get(i + 1).is_some_and(|t| t == ":");
    let mut used = Vec::new();
    for i in 0..tokens.len() {
        if (tokens[i] == "crate" || tokens[i] == "flankfit_engine") && path(i + 1) && (i == 0 || tokens[i - 1] != "$") {
            used.extend(heads(tokens, i + 3));
        }
        if tokens[i] == "super" && !(i >= 2 && tokens[i - 1] == ":" && tokens[i - 2] == ":") {
            let mut end = i;
            let mut climbed = 1;
            while path(end + 1) && tokens.get(end + 3).is_some_and(|t| t == "super") {
                (end, climbed) = (end + 3, climbed + 1);
            }
            if climbed >= depth && path(end + 1) {
                used.extend(heads(tokens, end + 3));
            }
        }
    }
    used
}

/// Whether a crate is named as the head of a path.
fn crate_used(tokens: &[String], name: &str) -> bool {
    let is = |i: usize, t: &str| tokens.get(i).is_some_and(|token| token == t);
    (0..tokens.len()).any(|i| {
        let head = i == 0 || tokens[i - 1] != ":";
        is(i, name) && head && ((is(i + 1, ":") && is(i + 2, ":")) || (i > 0 && is(i - 1, "use")))
    })
}

/// The top-level rooms, from the folders and files of both `src/`.
fn all_rooms() -> Vec<String> {
    let entries = ["engine/src", "src"].iter().flat_map(|folder| fs::read_dir(root().join(folder)).expect("sources"));
    let names =
        entries.map(|e| e.expect("an entry").path().file_stem().expect("a name").to_string_lossy().into_owned());
    names.filter(|n| n != "lib" && n != "main").collect()
}

fn files_of(room: &str) -> Vec<PathBuf> {
    let mut files = rust_files(&source_of(room).join(room));
    let alone = source_of(room).join(format!("{room}.rs"));
    if alone.exists() {
        files.push(alone);
    }
    files
}

#[test]
fn imports_point_downwards() {
    let rooms = all_rooms();
    let mut wrong = Vec::new();
    for rule in RULES {
        for file in files_of(rule.room) {
            let tokens = tokens(&split(&fs::read_to_string(&file).expect("a source file")).0);
            let name = file.strip_prefix(source_of(rule.room)).expect("below src").display().to_string();
            // Modules between this file and the crate root: `estimation/mod.rs` 1,
            // `estimation/fit.rs` 2.
            let depth = name.split('/').count() - usize::from(name.ends_with("mod.rs"));
            for used in rooms_used(&tokens, depth) {
                if rooms.contains(&used) && used != rule.room && !rule.rooms.contains(&used.as_str()) {
                    wrong.push(format!("{name} imports crate::{used}"));
                }
            }
            for foreign in rule.foreign {
                if crate_used(&tokens, foreign) {
                    wrong.push(format!("{name} uses the crate {foreign}"));
                }
            }
        }
    }
    wrong.dedup();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_engine_builds_on_mathematics_only() {
    let manifest = fs::read_to_string(root().join("engine/Cargo.toml")).expect("the engine's manifest");
    let table = manifest.split("[dependencies]").nth(1).and_then(|rest| rest.split("\n[").next()).expect("a table");
    let names = table.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split(['.', ' ']).next());
    let mut names: Vec<&str> = names.filter(|name| !name.is_empty()).collect();
    names.sort_unstable();
    assert_eq!(names, ENGINE_BUILDS_ON);
}

#[test]
fn sql_stays_in_the_store() {
    let heads = [
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
    let store = files_of("store");
    for file in sources().into_iter().filter(|file| !store.contains(file)) {
        for text in split(&fs::read_to_string(&file).expect("a source file")).1 {
            let start = text.trim_start();
            assert!(!heads.iter().any(|h| start.starts_with(h)), "{}: {start:?}", file.display());
        }
    }
}

/// The engine names its fields by types; JSON Pointers into a request are the service's.
#[test]
fn the_engine_knows_no_pointers() {
    for file in rust_files(&root().join("engine/src")) {
        for text in split(&fs::read_to_string(&file).expect("a source file")).1 {
            let name = text.strip_prefix('/').unwrap_or_default();
            assert!(!name.starts_with(|c: char| c.is_ascii_lowercase()), "{}: {text:?}", file.display());
        }
    }
}

/// Why the engine refuses something is a variant with its numbers: no reason is made of words.
#[test]
fn reasons_are_no_words() {
    let mut looked_at = 0;
    for file in rust_files(&root().join("engine/src")) {
        let name = file.file_stem().expect("a name").to_string_lossy().into_owned();
        if !(name.ends_with("fault") || matches!(&*name, "reason" | "error" | "warning")) {
            continue;
        }
        looked_at += 1;
        let (code, _) = split(&fs::read_to_string(&file).expect("a source file"));
        let dense: String = code.split_whitespace().collect();
        for word in ["Cow<", "From<&'staticstr>", "From<&str>", "From<String>", "Words("] {
            assert!(!dense.contains(word), "{} holds {word}", file.display());
        }
    }
    assert!(looked_at > 20, "only {looked_at} files of reasons were found");
}

#[test]
fn nothing_is_left_unfinished() {
    for file in sources() {
        let (code, _) = split(&fs::read_to_string(&file).expect("a source file"));
        let dense: String = code.split_whitespace().collect();
        for word in ["todo!", "unimplemented!", "dbg!(", "#[ignore", "#[allow(", "#![allow("] {
            assert!(!dense.contains(word), "{} holds {word}", file.display());
        }
    }
}

/// A clone is whole: what tests, examples, benches and tools read lies in it, and no test passes
/// because something is missing.
#[test]
fn nothing_outside_the_project_is_needed() {
    let own = root().join("tests/structure/main.rs");
    for room in ["engine", "src", "tests", "examples", "benches", "fuzz/fuzz_targets"] {
        for file in rust_files(&root().join(room)).into_iter().filter(|file| *file != own) {
            for text in split(&fs::read_to_string(&file).expect("a source file")).1 {
                let outside = text.starts_with("../") && !file.parent().expect("a folder").join(&text).exists();
                assert!(!outside && !text.contains("SKIPPED"), "{}: {text:?}", file.display());
            }
        }
    }
}

#[test]
fn the_reader_of_sources_reads() {
    let text = r##"
        //! use axum::Router; SELECT
        use crate::{estimation::{fit, Nodes}, http};
        use flankfit_engine::gear;
        /* use tokio::main; /* nested */ */
        fn f<'a>(c: char) -> bool { c == '"' || c == '\'' || super::super::store::x("SELECT 1", r#"a "b" c"#) }
    "##;
    let (code, strings) = split(text);
    assert_eq!(strings, ["SELECT 1", "a \"b\" c"]);
    let tokens = tokens(&code);
    assert_eq!(rooms_used(&tokens, 2), ["estimation", "http", "gear", "store"]);
    assert_eq!(rooms_used(&tokens, 3), ["estimation", "http", "gear"]);
    assert!(!crate_used(&tokens, "axum") && !crate_used(&tokens, "tokio"));
    assert!(crate_used(&self::tokens("let x = serde_json::to_string(&y);"), "serde_json"));
    assert!(crate_used(&self::tokens("use sqlx;"), "sqlx"));
}
