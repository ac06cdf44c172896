//! Sections one after another in a file: lines of JSON, compressed by zstd. The last line has the
//! digest of all before it, so a file that is cut off is found.

use std::io::{self, BufRead, BufReader, Read, Write};

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use uuid::Uuid;
use zstd::stream::{read::Decoder, write::Encoder};

use super::{
    error::ArchiveError,
    row::{Row, to_hex},
    section::{Digested, Key, Section},
};
use crate::jobs::callers::Tenant;

const FIRST: &str = "{\"flankfit\":\"export\",\"version\":1}\n";
/// No line of an export is longer: results are bounded by what a request may be.
const LONGEST: u64 = 1 << 30;

/// Writes a file.
pub struct ArchiveWriter<W: Write> {
    to: Encoder<'static, W>,
    digest: Sha256,
    sections: u64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Whole {
    sections: u64,
    sha256: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyLine {
    tenant: String,
    job: Uuid,
}

/// The lines that are no rows.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum Mark {
    Section(KeyLine),
    End(Digested),
    Whole(Whole),
}

impl<W: Write> ArchiveWriter<W> {
    pub fn begin(to: W) -> io::Result<Self> {
        let to = Encoder::new(to, zstd::DEFAULT_COMPRESSION_LEVEL)?;
        let mut writer = ArchiveWriter { to, digest: Sha256::new(), sections: 0 };
        writer.line(FIRST)?;
        Ok(writer)
    }

    /// Writes a line of a section.
    pub fn line(&mut self, line: &str) -> io::Result<()> {
        self.digest.update(line.as_bytes());
        self.to.write_all(line.as_bytes())
    }

    /// Ends a section.
    pub fn end(&mut self, Digested { rows, sha256 }: &Digested) -> io::Result<()> {
        self.sections += 1;
        self.line(&format!("{{\"end\":{{\"rows\":{rows},\"sha256\":\"{sha256}\"}}}}\n"))
    }

    /// Ends the file.
    pub fn finish(mut self) -> io::Result<W> {
        let sha256 = to_hex(&self.digest.finalize());
        let last = format!("{{\"whole\":{{\"sections\":{},\"sha256\":\"{sha256}\"}}}}\n", self.sections);
        self.to.write_all(last.as_bytes())?;
        self.to.finish()
    }
}

/// What stands in a file, a piece at a time.
#[derive(Debug)]
pub enum Listed {
    Section(Key),
    Row(Row),
    End(Digested),
}

/// Reads a file.
pub struct ArchiveReader<R: Read> {
    from: BufReader<Decoder<'static, BufReader<R>>>,
    digest: Sha256,
    sections: u64,
    lines: u64,
    section: Option<Section>,
}

impl<R: Read> ArchiveReader<R> {
    pub fn begin(from: R) -> Result<Self, ArchiveError> {
        let from = BufReader::new(Decoder::new(from)?);
        let mut reader = ArchiveReader { from, digest: Sha256::new(), sections: 0, lines: 0, section: None };
        match reader.next_line() {
            Ok(first) if first == FIRST => Ok(reader),
            Err(ArchiveError::Cut) => Err(ArchiveError::Cut),
            _ => Err(ArchiveError::Foreign),
        }
    }

    fn next_line(&mut self) -> Result<String, ArchiveError> {
        let mut line = String::new();
        self.lines += 1;
        let read = (&mut self.from).take(LONGEST).read_line(&mut line);
        match read {
            Ok(_) if line.ends_with('\n') => {}
            Err(error) if error.kind() == io::ErrorKind::InvalidData => return Err(self.damaged()),
            Ok(_) => return Err(ArchiveError::Cut),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Err(ArchiveError::Cut),
            // what is no frame any more
            Err(error) if error.kind() == io::ErrorKind::Other => return Err(self.damaged()),
            Err(error) => return Err(error.into()),
        }
        if !line.starts_with("{\"whole\"") {
            self.digest.update(line.as_bytes());
        }
        Ok(line)
    }

    fn damaged(&self) -> ArchiveError {
        ArchiveError::Damaged { line: self.lines }
    }

    /// What comes next; `None` once the whole file was read and is as it was written.
    pub fn next_part(&mut self) -> Result<Option<Listed>, ArchiveError> {
        let line = self.next_line()?;
        let marks = ["{\"section\"", "{\"end\"", "{\"whole\""];
        if !marks.iter().any(|mark| line.starts_with(mark)) {
            let row = Row::of_line(&line).filter(|row| row.to_line() == line);
            let (Some(row), Some(section)) = (row, &mut self.section) else { return Err(self.damaged()) };
            section.line(&line);
            return Ok(Some(Listed::Row(row)));
        }
        let mark = serde_json::from_str(&line).map_err(|_| self.damaged())?;
        match (mark, self.section.take()) {
            (Mark::Section(KeyLine { tenant, job }), None) => {
                let key = Key { tenant: Tenant::kept(&tenant).ok_or_else(|| self.damaged())?, job };
                let (section, first) = Section::begin(&key);
                if first != line {
                    return Err(self.damaged());
                }
                self.section = Some(section);
                Ok(Some(Listed::Section(key)))
            }
            (Mark::End(told), Some(section)) => {
                if section.end() != told {
                    return Err(self.damaged());
                }
                self.sections += 1;
                Ok(Some(Listed::End(told)))
            }
            (Mark::Whole(told), None) => {
                let sha256 = to_hex(&std::mem::take(&mut self.digest).finalize());
                let more = self.from.fill_buf().map_or(true, |rest| !rest.is_empty());
                if told.sections != self.sections || told.sha256 != sha256 || more {
                    return Err(self.damaged());
                }
                Ok(None)
            }
            _ => Err(self.damaged()),
        }
    }
}
