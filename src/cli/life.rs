//! `flankfit export`, `import` and `copy`: jobs from a database into a file, from a file into a
//! database, and from a database into another.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, BufWriter, Write as _},
    path::{Path, PathBuf},
};

use clap::Args;
use flankfit_engine::numerics::cancel::parts;
use tokio::runtime::{Builder, Runtime};
use uuid::Uuid;

use super::{CommandError, out::out, progress};
use crate::{
    api::jobs::carried,
    app::open_holdings,
    jobs::archive::{self, ArchiveError, ArchiveReader, ArchiveWriter, Digested, Holdings, Key},
};

#[derive(Debug, Args)]
pub struct ExportArguments {
    /// File to write; an existing file is not overwritten.
    file: PathBuf,
    /// Id of the job to export; without it all jobs.
    #[arg(long)]
    job: Option<Uuid>,
    /// Database: sqlite://FILE, or postgres://USER@HOST/NAME; a server may be running on it.
    #[arg(long, env = "FLANKFIT_DATABASE_URL", default_value = "sqlite://flankfit.db", hide_env_values = true)]
    database_url: String,
}

#[derive(Debug, Args)]
pub struct ImportArguments {
    /// A file that `flankfit export` wrote.
    file: PathBuf,
    /// Database: sqlite://FILE, with no server running on it, or postgres://OWNER@HOST/NAME with
    /// the owner's role.
    #[arg(long, env = "FLANKFIT_DATABASE_URL", default_value = "sqlite://flankfit.db", hide_env_values = true)]
    database_url: String,
}

#[derive(Debug, Args)]
pub struct CopyArguments {
    /// Source database; a server may be running on it.
    #[arg(long, value_name = "URL", env = "FLANKFIT_COPY_FROM", hide_env_values = true)]
    from: String,
    /// Target database: sqlite://FILE, with no server running on it, or postgres://OWNER@HOST/NAME
    /// with the owner's role.
    #[arg(long, value_name = "URL", env = "FLANKFIT_COPY_TO", hide_env_values = true)]
    to: String,
}

fn runtime() -> io::Result<Runtime> {
    Builder::new_current_thread().enable_all().build()
}

/// Numbers of jobs stored and skipped.
#[derive(Default)]
struct Count {
    stored: usize,
    there: usize,
}

impl Count {
    fn tell(&self) -> Result<(), CommandError> {
        Ok(writeln!(out(), "{} jobs stored, {} were there already", self.stored, self.there)?)
    }
}

pub fn export(arguments: &ExportArguments) -> Result<(), CommandError> {
    let runtime = runtime()?;
    let from = runtime.block_on(open_holdings(&arguments.database_url, false))?;
    let mut keys = runtime.block_on(from.keys())?;
    if let Some(job) = arguments.job {
        keys.retain(|key| key.job == job);
        if keys.is_empty() {
            return Err(ArchiveError::NoSuchJob(job).into());
        }
    }
    let path = &arguments.file;
    let unusable = |error: io::Error| match error.kind() {
        io::ErrorKind::AlreadyExists => format!("{} exists already; nothing is overwritten", path.display()),
        _ => format!("cannot write {}: {error}", path.display()),
    };
    // reserving the name refuses an existing file without a gap between looking and writing
    OpenOptions::new().write(true).create_new(true).open(path).map_err(unusable)?;
    let mut partial = path.clone().into_os_string();
    partial.push(".partial");
    let partial = PathBuf::from(partial);
    let written = progress::shown("export", || write(&runtime, &*from, &keys, &partial))
        .and_then(|count| Ok(fs::rename(&partial, path).map(|()| count)?));
    match written {
        Ok(count) => Ok(writeln!(out(), "{count} jobs written to {}", path.display())?),
        Err(error) => {
            // the reservation and the half file are ours; that they may be gone is no matter
            let _ = fs::remove_file(&partial);
            let _ = fs::remove_file(path);
            Err(error.into())
        }
    }
}

fn write(runtime: &Runtime, from: &dyn Holdings, keys: &[Key], to: &Path) -> Result<usize, ArchiveError> {
    let mut file = ArchiveWriter::begin(BufWriter::new(File::create(to)?))?;
    let (each, mut count) = (parts(keys.len()), 0);
    for key in keys {
        // one that was deleted before there were entries has left nothing
        count += usize::from(each.run(1, || runtime.block_on(archive::export(from, key, &mut file)))?);
    }
    let file = file.finish()?.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.sync_all()?;
    Ok(count)
}

/// Returns the jobs that the database lacks; all are checked before the first is stored.
fn new_of(runtime: &Runtime, to: &dyn Holdings, jobs: &[(Key, Digested)]) -> Result<Vec<bool>, ArchiveError> {
    // a store that is not reached is told of, even where there is nothing for it
    if jobs.is_empty() {
        runtime.block_on(to.keys())?;
    }
    let each = parts(jobs.len());
    let is_new = |(key, told)| each.run(1, || runtime.block_on(archive::is_new(to, key, told)));
    jobs.iter().map(|(key, told)| is_new((key, told))).collect()
}

/// Closes the store, also after a failed job, so that the database file is complete.
fn closed(runtime: &Runtime, to: &dyn Holdings, stored: Result<Count, CommandError>) -> Result<Count, CommandError> {
    let closed = runtime.block_on(to.close());
    let count = stored?;
    match closed? {
        true => Ok(count),
        false => Err(ArchiveError::StillOpen.into()),
    }
}

pub fn import(arguments: &ImportArguments) -> Result<(), CommandError> {
    let open =
        || File::open(&arguments.file).map_err(|error| format!("cannot read {}: {error}", arguments.file.display()));
    let whole = open()?;
    let again = open()?;
    let runtime = runtime()?;
    let count = progress::shown("import", || -> Result<Count, CommandError> {
        let stages = parts(3);
        let jobs = stages.run(1, || archive::listed(whole, carried::check))?;
        let to = runtime.block_on(open_holdings(&arguments.database_url, true))?;
        let store = || -> Result<Count, CommandError> {
            let new = stages.run(1, || new_of(&runtime, &*to, &jobs))?;
            stages.run(1, || {
                let mut file = ArchiveReader::begin(again)?;
                let (each, mut count) = (parts(jobs.len()), Count::default());
                for wanted in new {
                    each.run(1, || runtime.block_on(archive::import(&mut file, &*to, wanted)))?;
                    count.stored += usize::from(wanted);
                    count.there += usize::from(!wanted);
                }
                Ok(count)
            })
        };
        closed(&runtime, &*to, store())
    })?;
    count.tell()
}

pub fn copy(arguments: &CopyArguments) -> Result<(), CommandError> {
    let runtime = runtime()?;
    let from = runtime.block_on(open_holdings(&arguments.from, false))?;
    let to = runtime.block_on(open_holdings(&arguments.to, true))?;
    let count = progress::shown("copy", || -> Result<Count, CommandError> {
        let stages = parts(2);
        let store = || -> Result<Count, CommandError> {
            let (jobs, new) = stages.run(1, || -> Result<_, CommandError> {
                let mut jobs = Vec::new();
                for key in runtime.block_on(from.keys())? {
                    let told = runtime.block_on(archive::digest(&*from, &key))?;
                    jobs.push((key, told));
                }
                let new = new_of(&runtime, &*to, &jobs)?;
                Ok((jobs, new))
            })?;
            stages.run(1, || {
                let (each, mut count) = (parts(jobs.len()), Count::default());
                for ((key, _), wanted) in jobs.iter().zip(new) {
                    if wanted {
                        each.run(1, || runtime.block_on(archive::copy(&*from, &*to, key)))?;
                    }
                    count.stored += usize::from(wanted);
                    count.there += usize::from(!wanted);
                }
                Ok(count)
            })
        };
        closed(&runtime, &*to, store())
    })?;
    count.tell()
}
