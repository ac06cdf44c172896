//! A file of some repetitions of a study: lines of JSON, compressed by zstd. The first line says of
//! which study and which repetitions, the next ones are one repetition each, and the last has the
//! digest of all before it, so that a file that is cut off or changed is found.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, BufWriter, Read, Write},
    ops::Range,
    path::Path,
};

use flankfit_engine::estimation::randomization::{LevelOutcome, Outcome};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use sha2::{Digest as _, Sha256};
use zstd::stream::{read::Decoder, write::Encoder};

use crate::{api::ENGINE, cli::CommandError, jobs::rows::to_hex};

const KIND: &str = "study";
const VERSION: u32 = 1;
/// No line is longer: a request is smaller, and so is a repetition.
const LONGEST: u64 = 1 << 30;

/// The study of the repetitions.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Head {
    flankfit: String,
    version: u32,
    /// Who computed them: another engine may find other bits.
    pub engine: String,
    /// SHA-256 of the request's bytes: parts of one study have the same.
    pub request_sha256: String,
    /// Number of repetitions of the whole study.
    pub repetitions: usize,
    /// The first one here.
    pub from: usize,
    /// The first one that is no more here.
    pub to: usize,
    /// As it was given.
    pub request: String,
}

/// Whether the first line is one that can be read.
#[derive(Deserialize)]
struct Kind {
    flankfit: String,
    version: u32,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Repetition {
    /// Condition, log₁₀ of the determinant, ‖A − Â_R‖², ‖y − X Â_R‖², ‖y − X̃ Â_R‖² of each level.
    levels: Vec<[Exact; 5]>,
    rss: Exact,
    along: Vec<Exact>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct End {
    end_sha256: String,
}

/// A double as JSON, to the bit: the shortest decimal that reads as itself, or the name of what is
/// no number.
#[derive(Clone, Copy)]
struct Exact(f64);

impl Serialize for Exact {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.is_finite() {
            true => serializer.serialize_f64(self.0),
            false => serializer.serialize_str(&self.0.to_string()),
        }
    }
}

impl<'de> Deserialize<'de> for Exact {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Given {
            Number(f64),
            Name(String),
        }
        match Given::deserialize(deserializer)? {
            Given::Number(value) => Ok(Exact(value)),
            Given::Name(name) => match name.parse::<f64>() {
                Ok(value) if !value.is_finite() => Ok(Exact(value)),
                _ => Err(de::Error::custom("neither a number nor the name of what is none")),
            },
        }
    }
}

impl Head {
    pub fn new(request: String, repetitions: usize, which: &Range<usize>) -> Self {
        Head {
            flankfit: KIND.to_owned(),
            version: VERSION,
            engine: ENGINE.to_owned(),
            request_sha256: to_hex(&Sha256::digest(&request)),
            repetitions,
            from: which.start,
            to: which.end,
            request,
        }
    }
}

impl From<&Outcome> for Repetition {
    fn from(outcome: &Outcome) -> Self {
        let level = |l: &LevelOutcome| [l.condition, l.log10_determinant, l.error, l.rss, l.fitted_rss].map(Exact);
        Repetition {
            levels: outcome.levels.iter().map(level).collect(),
            rss: Exact(outcome.rss),
            along: outcome.along.iter().copied().map(Exact).collect(),
        }
    }
}

impl From<Repetition> for Outcome {
    fn from(repetition: Repetition) -> Self {
        let level = |results: [Exact; 5]| {
            let [condition, log10_determinant, error, rss, fitted_rss] = results.map(|exact| exact.0);
            LevelOutcome { condition, log10_determinant, error, rss, fitted_rss }
        };
        Outcome {
            levels: repetition.levels.into_iter().map(level).collect(),
            rss: repetition.rss.0,
            along: repetition.along.into_iter().map(|exact| exact.0).collect(),
        }
    }
}

/// Writes a file. It is there whole or not at all, so a part that is computed once more replaces
/// its own.
pub fn write(path: &Path, head: &Head, outcomes: &[Outcome]) -> Result<(), CommandError> {
    let unusable = |error: io::Error| format!("cannot write {}: {error}", path.display());
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut beside = tempfile::Builder::new();
    // read by others as the user's other files are: those of the system's folder are private
    #[cfg(unix)]
    beside.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let file = beside.tempfile_in(folder).map_err(unusable)?;
    let mut to = Encoder::new(BufWriter::new(file.as_file()), zstd::DEFAULT_COMPRESSION_LEVEL).map_err(unusable)?;
    let mut digest = Sha256::new();
    let mut line = |text: String| {
        digest.update(&text);
        digest.update("\n");
        writeln!(to, "{text}")
    };
    line(serde_json::to_string(head)?).map_err(unusable)?;
    for outcome in outcomes {
        line(serde_json::to_string(&Repetition::from(outcome))?).map_err(unusable)?;
    }
    let end = End { end_sha256: to_hex(&digest.finalize()) };
    writeln!(to, "{}", serde_json::to_string(&end)?).map_err(unusable)?;
    to.finish().and_then(|mut to| to.flush()).map_err(unusable)?;
    file.as_file().sync_all().map_err(unusable)?;
    file.persist(path).map_err(|failed| unusable(failed.error))?;
    Ok(())
}

/// Reads a file.
pub fn read(path: &Path) -> Result<(Head, Vec<Outcome>), CommandError> {
    let unusable = |error: io::Error| format!("cannot read {}: {error}", path.display());
    let file = File::open(path).map_err(unusable)?;
    let mut from = BufReader::new(Decoder::new(file).map_err(unusable)?);
    let mut next = || {
        let mut line = String::new();
        (&mut from).take(LONGEST).read_line(&mut line).map(|_| line)
    };
    let foreign = || format!("{} is no file of repetitions that flankfit study --raw wrote", path.display());
    let damaged = || format!("{} is cut off or damaged: compute its repetitions anew", path.display());
    // what is no frame of zstd has no begin of one; a frame that is cut ends within its first line
    let first = next().map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => damaged(),
        _ => foreign(),
    })?;
    let kind: Kind = serde_json::from_str(&first).map_err(|_| foreign())?;
    if kind.flankfit != KIND {
        return Err(foreign().into());
    }
    if kind.version != VERSION {
        let found = kind.version;
        return Err(format!("{} is of version {found}; this program reads version {VERSION}", path.display()).into());
    }
    let head: Head = serde_json::from_str(&first).map_err(|_| damaged())?;
    let mut digest = Sha256::new();
    digest.update(&first);
    let is_range = head.from < head.to && head.to <= head.repetitions;
    if !is_range || head.request_sha256 != to_hex(&Sha256::digest(&head.request)) {
        return Err(damaged().into());
    }
    let mut outcomes = Vec::new();
    for _ in head.from..head.to {
        let line = next().map_err(|_| damaged())?;
        digest.update(&line);
        let repetition: Repetition = serde_json::from_str(&line).map_err(|_| damaged())?;
        outcomes.push(repetition.into());
    }
    let last: End = next().ok().and_then(|line| serde_json::from_str(&line).ok()).ok_or_else(damaged)?;
    let is_whole = last.end_sha256 == to_hex(&digest.finalize());
    // a frame that is cut behind its last line has no end of its own
    if !is_whole || next().ok() != Some(String::new()) {
        return Err(damaged().into());
    }
    Ok((head, outcomes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubles_are_kept_to_the_bit() {
        let values = [0.1 + 0.2, -0.0, 5e-324, f64::MAX, 1.0, f64::INFINITY, f64::NEG_INFINITY, f64::MIN_POSITIVE];
        for value in values {
            let text = serde_json::to_string(&Exact(value)).unwrap();
            let read: Exact = serde_json::from_str(&text).unwrap();
            assert_eq!(read.0.to_bits(), value.to_bits(), "{text}");
        }
        let read: Exact = serde_json::from_str(&serde_json::to_string(&Exact(f64::NAN)).unwrap()).unwrap();
        assert!(read.0.is_nan());
        assert!(serde_json::from_str::<Exact>("\"1.5\"").is_err() && serde_json::from_str::<Exact>("null").is_err());
    }
}
