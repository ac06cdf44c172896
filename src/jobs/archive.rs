//! Archives of jobs: lines of JSON that are the same from every store. The format is in
//! `docs/how-to/data-life.md`.
//!
//! Each job is a section: a line that names it, a line for each row, and a line with the digest of
//! these. A store takes a section as a whole or not at all.

use std::io::{self, BufRead, BufReader, Read as _, Seek as _, Write as _};

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use tempfile::spooled_tempfile;
use tokio::sync::mpsc;
use uuid::Uuid;

use super::{
    callers::Tenant,
    frames,
    outcome::{RepositoryError, RepositoryFuture},
    rows::{Row, to_hex},
};

/// Rows that are on their way from or to a store.
pub const ON_THE_WAY: usize = 8;
/// No line is longer: what is kept is bounded by what a request may be.
const LONGEST: u64 = frames::LONGEST;
/// Bytes of a job in memory while it is read; a longer one is in a temporary file.
const IN_MEMORY: usize = 16 << 20;

/// Names a job.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    pub tenant: Tenant,
    pub job: Uuid,
}

/// The jobs of all tenants, as rows.
pub trait Holdings: Send + Sync {
    /// Every job that exists or existed, in the order of tenants and ids.
    fn keys(&self) -> RepositoryFuture<'_, Vec<Key>>;

    /// Sends the rows of a job and its entries, as one state of the store; none of a job that never
    /// existed.
    fn read(&self, key: Key, to: mpsc::Sender<Row>) -> RepositoryFuture<'_, ()>;

    /// Stores the rows of a job that does not exist, each with the number of its line; nothing if
    /// a row is `None`, or if the rows are not those of the job's entries.
    fn write<'a>(&'a self, key: Key, rows: &'a mut Rows<'_>) -> RepositoryFuture<'a, ()>;

    /// Ends the writing; returns whether all is in the file of the database alone, where it is a
    /// file.
    fn close(&self) -> RepositoryFuture<'_, bool>;
}

/// Rows with the numbers of their lines; `None` in place of a row that cannot be read.
pub type Rows<'a> = dyn Iterator<Item = Option<(u64, Row)>> + Send + 'a;

/// Why an archive was not read, or a job of it not stored.
#[derive(Debug, thiserror::Error)]
pub enum ArchiveError {
    #[error(transparent)]
    Store(#[from] RepositoryError),
    #[error(transparent)]
    File(#[from] io::Error),
    #[error("line {line}: {why}")]
    Line { line: u64, why: String },
    #[error("line {line}, job {job}: {why}; the job is not stored")]
    Row { line: u64, job: Uuid, why: String },
    #[error("job {job} exists and differs; it is not stored")]
    Differs { job: Uuid },
    #[error("job {job} is not stored: {error}")]
    NotStored { job: Uuid, error: RepositoryError },
}

impl ArchiveError {
    /// Returns whether only one job is at fault, so that the next one can be read.
    pub fn is_of_one_job(&self) -> bool {
        matches!(self, ArchiveError::Row { .. } | ArchiveError::Differs { .. } | ArchiveError::NotStored { .. })
    }
}

/// The lines that are no rows.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Mark {
    Job { tenant: String, job: Uuid },
    End { rows: u64, sha256: String },
    Archive { jobs: u64 },
}

impl Mark {
    fn line(&self) -> String {
        serde_json::to_string(self).unwrap_or_default() + "\n"
    }
}

/// Digests the lines of a section.
#[derive(Default)]
struct Section(Sha256, u64);

impl Section {
    fn line(&mut self, line: &str) {
        self.0.update(line.as_bytes());
        self.1 += 1;
    }

    fn end(self) -> Mark {
        Mark::End { rows: self.1 - 1, sha256: to_hex(&self.0.finalize()) }
    }
}

/// Writes the section of a job; returns whether the job exists or existed. An error of `write` ends
/// it.
pub async fn export<F>(from: &dyn Holdings, key: &Key, mut write: impl FnMut(String) -> F) -> Result<bool, ArchiveError>
where
    F: Future<Output = io::Result<()>>,
{
    let (rows, mut coming) = mpsc::channel::<Row>(ON_THE_WAY);
    let writing = async move {
        let mut section = Section::default();
        while let Some(row) = coming.recv().await {
            if section.1 == 0 {
                let first = Mark::Job { tenant: key.tenant.as_str().to_owned(), job: key.job }.line();
                section.line(&first);
                write(first).await?;
            }
            let line = row.to_line();
            section.line(&line);
            write(line).await?;
        }
        let is_there = section.1 > 0;
        if is_there {
            write(section.end().line()).await?;
        }
        Ok::<_, io::Error>(is_there)
    };
    let (read, written) = tokio::join!(from.read(key.clone(), rows), writing);
    let is_there = written?;
    read?;
    Ok(is_there)
}

/// Returns the last line of an archive.
pub fn last_line(jobs: u64) -> String {
    Mark::Archive { jobs }.line()
}

/// Reads an archive, job by job.
pub struct ArchiveReader<R> {
    from: R,
    line: u64,
    jobs: u64,
    /// Longest line in bytes.
    longest: u64,
}

/// Result for the next job of an archive.
#[derive(Debug, PartialEq, Eq)]
pub enum Imported {
    Stored,
    /// The same job exists.
    Exists,
    /// No job is left.
    Nothing,
}

impl<R: BufRead> ArchiveReader<R> {
    pub fn new(from: R) -> Self {
        ArchiveReader { from, line: 0, jobs: 0, longest: LONGEST }
    }

    fn wrong<T>(&self, why: &str) -> Result<T, ArchiveError> {
        Err(ArchiveError::Line { line: self.line, why: why.to_owned() })
    }

    fn next_line(&mut self) -> Result<String, ArchiveError> {
        let mut line = Vec::new();
        self.line += 1;
        // one byte more than allowed shows that it is longer
        (&mut self.from).take(self.longest + 1).read_until(b'\n', &mut line)?;
        if line.len() as u64 > self.longest {
            return self.wrong(&format!("it is longer than {} bytes, as no line of an archive is", self.longest));
        }
        if line.last() != Some(&b'\n') {
            return self.wrong("the archive is cut off here");
        }
        String::from_utf8(line).or_else(|_| self.wrong("it is not UTF-8"))
    }

    /// Stores the next job, each row of which `check` accepts; else it names the column, and why.
    pub async fn import(
        &mut self,
        to: &dyn Holdings,
        check: fn(&Row) -> Result<(), String>,
    ) -> Result<Imported, ArchiveError> {
        let first = self.next_line()?;
        let key = match serde_json::from_str(&first) {
            Ok(Mark::Job { tenant, job }) => match Tenant::kept(&tenant) {
                Some(tenant) => Key { tenant, job },
                None => return self.wrong("the tenant is not the name of one"),
            },
            Ok(Mark::Archive { jobs }) if jobs == self.jobs => return Ok(Imported::Nothing),
            Ok(Mark::Archive { .. }) => return self.wrong("jobs before it are missing"),
            _ => return self.wrong("it does not begin a job as an archive of this version does"),
        };
        self.jobs += 1;
        let (job, begin) = (key.job, self.line);
        let there = section(to, &key).await?;
        let (mut own, mut lines) = (Section::default(), spooled_tempfile(IN_MEMORY));
        own.line(&first);
        // the store locks nothing before all is there
        let end = loop {
            let line = self.next_line()?;
            if let Ok(end @ Mark::End { .. }) = serde_json::from_str::<Mark>(&line) {
                break end.line();
            }
            own.line(&line);
            lines.write_all(line.as_bytes())?;
        };
        if own.end().line() != end {
            let why = "the job has changed since it was written".to_owned();
            return Err(ArchiveError::Row { line: self.line, job, why });
        }
        match there {
            Some(there) if there == end => return Ok(Imported::Exists),
            Some(_) => return Err(ArchiveError::Differs { job }),
            None => lines.rewind()?,
        }
        let mut refused = None;
        let mut rows = BufReader::new(lines).lines().zip(begin + 1..).map(|(line, number)| {
            let row = line.map_err(|error| error.to_string()).and_then(|line| {
                let row = Row::of_line(&line).map_err(|(column, why)| match column {
                    Some(column) => format!("`{column}`: {why}"),
                    None => why.to_owned(),
                })?;
                check(&row).map(|()| row)
            });
            let row = row.map_err(|why| refused = Some(ArchiveError::Row { line: number, job, why }));
            row.ok().map(|row| (number, row))
        });
        let written = to.write(key, &mut rows).await;
        drop(rows);
        match refused {
            Some(error) => Err(error),
            None => written.map(|()| Imported::Stored).map_err(|error| ArchiveError::NotStored { job, error }),
        }
    }
}

/// Returns the last line of the section of a job; none of a job that does not exist.
async fn section(of: &dyn Holdings, key: &Key) -> Result<Option<String>, ArchiveError> {
    let mut last = String::new();
    let is_there = export(of, key, |line| {
        last = line;
        std::future::ready(Ok(()))
    });
    Ok(is_there.await?.then_some(last))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line that would fill the memory is named by its number, and no more of it is read.
    #[test]
    fn overlong_and_cut_lines_are_named_by_number() {
        let text = [b"{}\n".as_slice(), &b" ".repeat(2 << 20)].concat();
        let mut reader = ArchiveReader { longest: 1 << 20, ..ArchiveReader::new(&text[..]) };
        assert_eq!(reader.next_line().unwrap(), "{}\n");
        let refused = reader.next_line().unwrap_err().to_string();
        assert!(refused.starts_with("line 2: it is longer than 1048576 bytes"), "{refused}");
        assert_eq!(reader.from.len(), (1 << 20) - 1);
        let cut = ArchiveReader::new(&b"{}"[..]).next_line().unwrap_err().to_string();
        assert_eq!(cut, "line 1: the archive is cut off here");
    }
}
