//! Greatest width and length of sources, so that a reader can take them in at once.
//!
//! Exceptions are named below, each with its present length. They may become shorter or go, and no
//! new one is needed where a file or a function has a part with a name of its own.

use std::fs;

use super::{root, rust_files};

/// Columns of a line of code. Strings do not count: `rustfmt` cannot break them.
const CODE_WIDTH: usize = 120;
/// Columns of a line that is a comment. Rows of tables and addresses do not count.
const COMMENT_WIDTH: usize = 100;
const FILE_LINES: usize = 500;
const FUNCTION_LINES: usize = 100;

/// Files with wider lines, and how many.
const WIDE_LINES: &[(&str, usize)] = &[];

/// Files with more lines, and how many.
const LONG_FILES: &[(&str, usize)] = &[];

/// Functions with more lines, and how many.
const LONG_FUNCTIONS: &[(&str, &str, usize)] = &[];

/// Every source of the workspace with its name.
fn all_sources() -> Vec<(String, String)> {
    let folders = ["benches", "engine", "fuzz/fuzz_targets", "src", "tests", "xtask"];
    let files = folders.iter().flat_map(|folder| rust_files(&root().join(folder)));
    let sources: Vec<_> = files
        .map(|file| {
            let name = file.strip_prefix(root()).expect("inside").to_string_lossy().replace('\\', "/");
            (name, fs::read_to_string(&file).expect("a source file"))
        })
        .collect();
    assert!(sources.len() > 600, "only {} sources were found", sources.len());
    sources
}

/// The columns of a line without the insides of its strings. `raw` is the end of the raw string
/// that the line begins in, and then of the one that it ends in.
fn code_width(line: &str, raw: &mut Option<String>) -> usize {
    let mut width = 0;
    let mut rest = line;
    loop {
        if let Some(end) = raw.as_ref() {
            let Some(at) = rest.find(end.as_str()) else { return width };
            width += end.len();
            rest = &rest[at + end.len()..];
            *raw = None;
        }
        let Some(quote) = rest.find('"') else { return width + rest.chars().count() };
        let before = &rest[..quote];
        width += before.chars().count() + 1;
        let unhashed = before.trim_end_matches('#');
        rest = &rest[quote + 1..];
        if unhashed.ends_with('r') {
            *raw = Some(format!("\"{}", &before[unhashed.len()..]));
        } else if before.ends_with('\'') {
            // the character '"'
        } else {
            let mut escaped = false;
            let end = rest.find(|c: char| {
                let ends = c == '"' && !escaped;
                escaped = c == '\\' && !escaped;
                ends
            });
            // a string that goes on in the next line
            let Some(end) = end else { return width };
            width += 1;
            rest = &rest[end + 1..];
        }
    }
}

fn is_free(comment: &str) -> bool {
    let text = comment.trim_start_matches(['/', '!']).trim();
    (text.starts_with('|') && text.ends_with('|')) || text.contains("://") || text.starts_with("[`")
}

#[test]
fn lines_are_not_too_wide() {
    let mut wrong = Vec::new();
    for (name, text) in all_sources() {
        let (mut raw, mut wide) = (None, Vec::new());
        for (number, line) in (1..).zip(text.lines()) {
            let comment = raw.is_none() && line.trim_start().starts_with("//");
            let (width, most) = match comment {
                true if is_free(line) => (0, COMMENT_WIDTH),
                true => (line.chars().count(), COMMENT_WIDTH),
                false => (code_width(line, &mut raw), CODE_WIDTH),
            };
            if width > most {
                wide.push(format!("{name}:{number} has {width} columns, at most {most}"));
            }
        }
        let known = WIDE_LINES.iter().find(|(file, _)| *file == name).map_or(0, |(_, count)| *count);
        if wide.len() < known {
            wrong.push(format!("{name} has {} wide lines now: correct WIDE_LINES", wide.len()));
        } else if wide.len() > known {
            wrong.append(&mut wide);
        }
    }
    assert!(wrong.is_empty(), "break these lines (`cargo fmt` does not where it cannot):\n{}", wrong.join("\n"));
}

/// Names and lengths of the functions of a formatted source: a function ends with the first `}` as
/// far to the right as it begins.
fn functions(text: &str) -> Vec<(String, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let mut found = Vec::new();
    for (begin, line) in lines.iter().enumerate() {
        let indent = &line[..line.len() - line.trim_start().len()];
        let mut words = line.split_whitespace().skip_while(|word| {
            word.starts_with("pub") || ["const", "async", "unsafe", "super)", "crate)"].contains(word)
        });
        let (Some("fn"), Some(name)) = (words.next(), words.next()) else { continue };
        if line.ends_with('}') || line.ends_with(';') {
            continue;
        }
        let end = format!("{indent}}}");
        let length = lines[begin..].iter().position(|line| *line == end).map_or(0, |last| last + 1);
        found.push((name.split(['(', '<']).next().unwrap_or(name).to_owned(), length));
    }
    found
}

#[test]
fn files_and_functions_are_not_too_long() {
    let mut wrong = Vec::new();
    let mut known_files = LONG_FILES.to_vec();
    let mut known_functions = LONG_FUNCTIONS.to_vec();
    let mut count = 0;
    for (name, text) in all_sources() {
        let length = text.lines().count();
        let known = known_files.iter().position(|(file, _)| *file == name).map(|at| known_files.remove(at).1);
        if length > known.unwrap_or(FILE_LINES) {
            wrong.push(format!("{name} has {length} lines, at most {}: split it", known.unwrap_or(FILE_LINES)));
        } else if known.is_some() && length <= FILE_LINES {
            wrong.push(format!("{name} is short now: take it from LONG_FILES"));
        }
        for (function, length) in functions(&text) {
            count += 1;
            let at = known_functions.iter().position(|(file, known, _)| *file == name && *known == function);
            let known = at.map(|at| known_functions.remove(at).2);
            if length > known.unwrap_or(FUNCTION_LINES) {
                let most = known.unwrap_or(FUNCTION_LINES);
                wrong.push(format!("{name}: {function} has {length} lines, at most {most}: give a part a name"));
            } else if known.is_some() && length <= FUNCTION_LINES {
                wrong.push(format!("{name}: {function} is short now: take it from LONG_FUNCTIONS"));
            }
        }
    }
    assert!(count > 5000, "only {count} functions were found");
    let gone = known_files.iter().map(|(file, _)| *file).chain(known_functions.iter().map(|(_, name, _)| *name));
    wrong.extend(gone.map(|name| format!("there is no {name} any more: take it from the exceptions")));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn widths_and_lengths_are_measured() {
    let width = |line: &str| code_width(line, &mut None);
    assert_eq!(width("let x = 1;"), 10);
    assert_eq!(width(r#"let x = "a\"b" + y;"#), 15);
    assert_eq!(width(r##"let x = r#"a"b"#;"##), 14);
    assert_eq!(width(r#"let c = '"'; let s = "abc";"#), 24);
    let mut raw = None;
    assert_eq!(code_width(r##"f(r#"{"a":"##, &mut raw), 5);
    assert_eq!(code_width(r#"  "long": 1, "#, &mut raw), 0);
    assert_eq!((code_width(r##"}"#);"##, &mut raw), raw), (4, None));
    assert!(is_free("/// | a | b |") && is_free("// https://example.org") && !is_free("/// |A| is small"));
    let text = "impl X {\n    pub const fn a(&self) -> u8 {\n        if b {\n        }\n    }\n}\nfn c() {}\n";
    assert_eq!(functions(text), [("a".to_owned(), 4)]);
}
