//! Words of comments (CONTRIBUTING.md, *Terms* and *Prose*).

use std::fs;

use crate::{files, root};

/// Folders with the extensions of their sources.
const SOURCES: [(&str, &[&str]); 6] = [
    ("benches", &["rs"]),
    ("engine", &["rs"]),
    ("src", &["rs"]),
    ("tests", &["rs"]),
    ("web", &["js", "mjs", "css"]),
    ("xtask", &["rs"]),
];

/// Folders of others' sources.
const FOREIGN: [&str; 2] = ["web/node_modules", "web/vendor"];

/// Words with which a comment does not begin.
const BEGINNINGS: [&str; 5] = ["Of ", "What ", "Whether it ", "Where ", "There "];

/// Words outside code spans that no comment has.
const AVOIDED: [&str; 10] =
    ["told", "tells", "stands", "beside", "beyond", "answers", "faults", "mended", "room", "door"];

#[test]
fn comments_are_in_plain_words() {
    let mut found = Vec::new();
    let sources = SOURCES.iter().flat_map(|(folder, extensions)| files(&root().join(folder), extensions));
    for file in sources.filter(|file| !FOREIGN.iter().any(|folder| file.starts_with(root().join(folder)))) {
        let text = fs::read_to_string(&file).expect("a source file");
        let rust = file.extension().is_some_and(|e| e == "rs");
        for (number, line, begins) in comments(&text, rust) {
            let mut words = line.split('`').step_by(2).flat_map(|part| part.split(|c: char| !c.is_alphanumeric()));
            if begins && BEGINNINGS.iter().any(|word| line.starts_with(word))
                || words.any(|word| AVOIDED.contains(&word))
            {
                found.push(format!("{}:{number}: {line}", file.display()));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// The lines of comments by their numbers; the flag marks the first words of a comment (in Rust
/// of a doc comment).
fn comments(text: &str, rust: bool) -> Vec<(usize, &str, bool)> {
    let (mut found, mut in_block, mut begun) = (Vec::new(), false, false);
    for (k, line) in text.lines().map(str::trim).enumerate() {
        if !in_block && !line.starts_with("//") && !line.starts_with("/*") {
            begun = false;
            continue;
        }
        begun &= in_block || line.starts_with("//");
        in_block = (in_block || line.starts_with("/*")) && !line.contains("*/");
        let comment = line.split("*/").next().unwrap_or_default();
        let words = comment.trim_start_matches(['/', '*', '!', ' ']);
        let documents = !rust || line.starts_with("///") || line.starts_with("//!");
        found.push((k + 1, words, documents && !begun));
        begun |= !words.is_empty();
    }
    found
}
