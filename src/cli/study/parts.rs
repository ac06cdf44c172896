//! A study in parts, of which each may be computed on a machine of its own: some repetitions into a
//! file, and the answer from the files of all of them.

use std::{
    fs, io,
    ops::Range,
    path::{Path, PathBuf},
    str::FromStr,
};

use flankfit_engine::estimation::randomization::Outcome;

use super::{
    explain,
    raw::{self, Head},
};
use crate::{
    api::{
        ENGINE,
        studies::{
            reader::read_in_parts,
            result::{self, RandomizationResult},
        },
    },
    cli::CommandError,
};

/// Which repetitions a part has.
#[derive(Clone, Debug, PartialEq)]
pub enum Which {
    /// Those from A on and before B.
    Between(Range<usize>),
    /// One of several equal parts, counted from 0.
    Share { index: usize, of: usize },
}

impl FromStr for Which {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let both = |between: &str| -> Option<(usize, usize)> {
            let (one, other) = text.split_once(between)?;
            Some((one.parse().ok()?, other.parse().ok()?))
        };
        match (both(".."), both("/")) {
            (Some((from, to)), _) if from < to => Ok(Which::Between(from..to)),
            (_, Some((index, of))) if index < of => Ok(Which::Share { index, of }),
            _ => Err("neither A..B, repetitions from A on and before B, nor I/N, part I of N, from 0 on".to_owned()),
        }
    }
}

impl Which {
    /// The repetitions of a study of so many.
    fn of(&self, all: usize) -> Result<Range<usize>, String> {
        match *self {
            Which::Between(Range { start, end }) if end <= all => Ok(start..end),
            Which::Between(Range { start, end }) => {
                Err(format!("the study has {all} repetitions, so not all of {start}..{end}"))
            }
            Which::Share { index, of } if of <= all => {
                // equal but for one; the product is far within 64 bits
                let begin = |index: usize| (index as u64 * all as u64 / of as u64) as usize;
                Ok(begin(index)..begin(index + 1))
            }
            Which::Share { of, .. } => Err(format!("a study of {all} repetitions has no {of} parts")),
        }
    }
}

/// Computes a part and writes it; says which it was.
pub fn write(text: Vec<u8>, which: &Which, to: &Path) -> Result<String, CommandError> {
    let checked = read_in_parts(&text).map_err(|problem| explain(&problem))?;
    let all = checked.repetitions;
    let range = which.of(all)?;
    let outcomes = result::repetitions(&checked, range.clone()).map_err(|problem| explain(&problem))?;
    raw::write(to, &Head::new(String::from_utf8(text)?, all, &range), &outcomes)?;
    Ok(format!("repetitions {}..{} of {all} written to {}", range.start, range.end, to.display()))
}

/// The answer from files that hold all repetitions of a study between them.
pub fn join(places: &[PathBuf]) -> Result<RandomizationResult, CommandError> {
    let mut parts = Vec::new();
    for path in files(places)? {
        let (head, outcomes) = raw::read(&path)?;
        parts.push(Part { path, head, outcomes });
    }
    let Some(first) = parts.first() else { return Err("there is no file to join".into()) };
    for part in &parts {
        let (path, engine) = (part.path.display(), &part.head.engine);
        if engine != ENGINE {
            return Err(format!("{path} was computed by {engine}; {ENGINE} joins only what it computed itself").into());
        }
        if part.head.request_sha256 != first.head.request_sha256 {
            return Err(format!("{path} is of another study than {}", first.path.display()).into());
        }
    }
    let checked = read_in_parts(first.head.request.as_bytes()).map_err(|problem| explain(&problem))?;
    parts.sort_by_key(|part| part.head.from);
    are_all(&parts, checked.repetitions)?;
    let outcomes: Vec<Outcome> = parts.into_iter().flat_map(|part| part.outcomes).collect();
    if outcomes.len() != checked.repetitions || !outcomes.iter().all(|outcome| checked.study.takes(outcome)) {
        return Err("the repetitions in the files are not of the study that the files name".into());
    }
    Ok(result::of_repetitions(checked, &outcomes).map_err(|problem| explain(&problem))?)
}

struct Part {
    path: PathBuf,
    head: Head,
    outcomes: Vec<Outcome>,
}

/// Each file itself, and those of each folder by their names.
fn files(places: &[PathBuf]) -> Result<Vec<PathBuf>, CommandError> {
    let mut files = Vec::new();
    for place in places {
        if !place.is_dir() {
            files.push(place.clone());
            continue;
        }
        let unusable = |error: io::Error| format!("cannot read {}: {error}", place.display());
        let begin = files.len();
        for entry in fs::read_dir(place).map_err(unusable)? {
            let path = entry.map_err(unusable)?.path();
            // what begins with a dot is being written, or another program's
            let is_hidden = path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
            if !is_hidden && path.is_file() {
                files.push(path);
            }
        }
        files[begin..].sort();
    }
    Ok(files)
}

/// Whether parts in order hold each repetition once.
fn are_all(parts: &[Part], all: usize) -> Result<(), String> {
    for pair in parts.windows(2) {
        let [one, other] = pair else { continue };
        if other.head.from < one.head.to {
            let end = one.head.to.min(other.head.to);
            let (path, second) = (one.path.display(), other.path.display());
            return Err(format!("{path} and {second} both have the repetitions {}..{end}", other.head.from));
        }
    }
    let ends = parts.iter().map(|part| part.head.to);
    let begins = parts.iter().map(|part| part.head.from).chain([all]);
    let missing: Vec<String> = [0]
        .into_iter()
        .chain(ends)
        .zip(begins)
        .filter(|(end, begin)| end < begin)
        .map(|(end, begin)| format!("{end}..{begin}"))
        .collect();
    match missing.is_empty() {
        true => Ok(()),
        false => Err(format!("of {all} repetitions these are missing: {}", missing.join(", "))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_named_by_their_ends_or_by_their_number() {
        let of = |text: &str| text.parse::<Which>()?.of(100);
        assert_eq!(of("0..100"), Ok(0..100));
        assert_eq!(of("7..8"), Ok(7..8));
        assert_eq!(of("0/1"), Ok(0..100));
        assert_eq!((of("0/3"), of("1/3"), of("2/3")), (Ok(0..33), Ok(33..66), Ok(66..100)));
        for text in ["", "7", "7..7", "8..7", "..7", "7..", "3/3", "a/b", "0..101", "-1..3", "0/101", "1..2/3"] {
            assert!(of(text).is_err(), "{text}");
        }
        // every share of every number, end to end
        for of in [1, 2, 7, 99, 100] {
            let parts = (0..of).map(|index| Which::Share { index, of }.of(100).unwrap());
            let end = parts.fold(0, |end, part| {
                assert!(part.start == end && part.end > end);
                part.end
            });
            assert_eq!(end, 100);
        }
    }
}
