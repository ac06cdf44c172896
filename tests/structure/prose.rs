//! Words of comments (CONTRIBUTING.md, *Terms* and *Prose*).

use std::fs;

use crate::{root, rust_files};

const FOLDERS: &str = "benches engine src tests xtask";

/// Words with which a doc comment does not begin.
const BEGINNINGS: [&str; 5] = ["Of ", "What ", "Whether it ", "Where ", "There "];

/// Words outside code spans that no comment has.
const AVOIDED: [&str; 10] =
    ["told", "tells", "stands", "beside", "beyond", "answers", "faults", "mended", "room", "door"];

#[test]
fn comments_are_in_plain_words() {
    let is_doc = |line: &str| line.starts_with("///") || line.starts_with("//!");
    let mut found = Vec::new();
    for file in FOLDERS.split(' ').flat_map(|folder| rust_files(&root().join(folder))) {
        let text = fs::read_to_string(&file).expect("a source file");
        let lines: Vec<&str> = text.lines().map(str::trim_start).collect();
        for (k, line) in lines.iter().enumerate().filter(|(_, line)| line.starts_with("//")) {
            let first = is_doc(line) && (k == 0 || !is_doc(lines[k - 1]));
            let begins = first && BEGINNINGS.iter().any(|word| line[3..].trim_start().starts_with(word));
            let mut words = line.split('`').step_by(2).flat_map(|part| part.split(|c: char| !c.is_alphanumeric()));
            if begins || words.any(|word| AVOIDED.contains(&word)) {
                found.push(format!("{}:{}: {line}", file.display(), k + 1));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}
