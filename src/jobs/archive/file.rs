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
use crate::jobs::{callers::Tenant, frames};

const FIRST: &str = "{\"flankfit\":\"export\",\"version\":1}\n";
/// No line is longer: what is kept is bounded by what a request may be.
const LONGEST: u64 = frames::LONGEST;
/// What is written here is not read back further, 8 MiB, to be unpacked.
const WINDOW_LOG: u32 = 23;

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

    /// Writes a line of a section; what could not be read again is not written.
    pub fn line(&mut self, line: &str) -> io::Result<()> {
        if line.len() as u64 > LONGEST {
            return Err(io::Error::other(format!("a row of {} bytes is longer than a line may be", line.len())));
        }
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
    /// Longest line in bytes.
    longest: u64,
}

impl<R: Read> ArchiveReader<R> {
    pub fn begin(from: R) -> Result<Self, ArchiveError> {
        Self::within(from, LONGEST)
    }

    /// Of a file of which no line is longer.
    fn within(from: R, longest: u64) -> Result<Self, ArchiveError> {
        let mut decoder = Decoder::new(from)?;
        decoder.window_log_max(WINDOW_LOG)?;
        let from = BufReader::new(decoder);
        let mut reader = ArchiveReader { from, digest: Sha256::new(), sections: 0, lines: 0, section: None, longest };
        match reader.next_line() {
            Ok(first) if first == FIRST => Ok(reader),
            Err(error @ (ArchiveError::Cut | ArchiveError::TooLong { .. })) => Err(error),
            _ => Err(ArchiveError::Foreign),
        }
    }

    fn next_line(&mut self) -> Result<String, ArchiveError> {
        let mut line = String::new();
        self.lines += 1;
        // one more than it may be tells that it is longer
        let read = (&mut self.from).take(self.longest + 1).read_line(&mut line);
        match read {
            Ok(bytes) if bytes as u64 > self.longest => {
                return Err(ArchiveError::TooLong { line: self.lines, longest: self.longest });
            }
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

    /// Returns the number of the line that was read last, from 1.
    pub fn line(&self) -> u64 {
        self.lines
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

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    fn packed(text: &[u8], window_log: u32) -> Vec<u8> {
        let mut to = Encoder::new(Vec::new(), 1).unwrap();
        to.window_log(window_log).unwrap();
        to.write_all(text).unwrap();
        to.finish().unwrap()
    }

    /// A line that would fill the memory is told by its number, and no more of it is read.
    #[test]
    fn a_line_without_an_end_is_told_by_its_number() {
        let section = "{\"section\":{\"tenant\":\"default\",\"job\":\"0190b0de-0000-7000-8000-000000000000\"}}\n";
        let hostile = [FIRST.as_bytes(), section.as_bytes(), &b" ".repeat(8 << 20)].concat();
        let file = packed(&hostile, 20);
        assert!(file.len() < 4096, "{}", file.len());
        let mut reader = ArchiveReader::within(&file[..], 1 << 20).unwrap();
        assert!(matches!(reader.next_part(), Ok(Some(Listed::Section(_)))));
        let refused = reader.next_part().unwrap_err();
        assert!(matches!(refused, ArchiveError::TooLong { line: 3, longest: 1_048_576 }), "{refused}");
        assert!(refused.to_string().starts_with("line 3 of the file is longer than 1048576 bytes"), "{refused}");
        let endless = packed(&b"x".repeat(2 << 20), 20);
        assert!(matches!(ArchiveReader::within(&endless[..], 1 << 20), Err(ArchiveError::TooLong { line: 1, .. })));
        // as long as it may be
        let mut whole = ArchiveReader::within(&file[..], 8 << 20).unwrap();
        assert!(whole.next_part().is_ok());
        assert!(matches!(whole.next_part(), Err(ArchiveError::Cut)));
    }

    /// A frame that asks for more memory to be unpacked than this program's do is none of its.
    #[test]
    fn a_window_that_is_too_large_is_refused() {
        let mut noise = 7_u64;
        let mut text = FIRST.as_bytes().to_vec();
        while text.len() < 20 << 20 {
            noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            text.extend(noise.to_le_bytes().map(|byte| b' ' + byte % 64));
        }
        assert!(matches!(ArchiveReader::begin(&packed(&text, 24)[..]), Err(ArchiveError::Foreign)));
        assert!(ArchiveReader::begin(&packed(&text, 22)[..]).is_ok());
    }
}
