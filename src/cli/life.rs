//! `flankfit export`, `import` and `purge`: jobs as JSON lines, out of a database and into another,
//! and old jobs purged.

use std::{
    fs::{self, File, OpenOptions},
    future::ready,
    io::{self, BufReader, BufWriter, Write},
    path::{Path, PathBuf},
    sync::Arc,
};

use clap::Args;
use flankfit_engine::numerics::cancel::parts;
use jiff::SignedDuration;
use tokio::runtime::Runtime;
use uuid::Uuid;

use super::{CommandError, called, out::out, progress, runtime};
use crate::{
    api::jobs::carried,
    app::{open_holdings, open_shared},
    config::within,
    jobs::{
        Caller, JobService, OrderedIds, SystemClock, actor,
        archive::{self, ArchiveError, ArchiveReader, Holdings, Imported, Key, last_line},
    },
};

/// A hundred years, in days.
const MOST_DAYS: u32 = 36_525;
/// Jobs that are looked up at a time.
const AT_A_TIME: u32 = 100;

#[derive(Debug, Args)]
pub struct ExportArguments {
    /// File to write, which must not exist; `-` for standard output.
    #[arg(default_value = "-")]
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
    /// File to read; `-` for standard input.
    #[arg(default_value = "-")]
    file: PathBuf,
    /// Database: sqlite://FILE, with no server running on it, or postgres://OWNER@HOST/NAME with
    /// the owner's role.
    #[arg(long, env = "FLANKFIT_DATABASE_URL", default_value = "sqlite://flankfit.db", hide_env_values = true)]
    database_url: String,
}

#[derive(Debug, Args)]
pub struct PurgeArguments {
    /// Days without activity after which a job is purged.
    #[arg(long, value_name = "DAYS", value_parser = within(1..=MOST_DAYS))]
    older_than: u32,
    /// Database: sqlite://FILE, or postgres://USER@HOST/NAME; a server may be running on it.
    #[arg(long, env = "FLANKFIT_DATABASE_URL", default_value = "sqlite://flankfit.db", hide_env_values = true)]
    database_url: String,
}

pub fn export(arguments: &ExportArguments) -> Result<(), CommandError> {
    let runtime = runtime()?;
    let from = runtime.block_on(open_holdings(&arguments.database_url, false))?;
    let mut keys = runtime.block_on(from.keys())?;
    if let Some(job) = arguments.job {
        keys.retain(|key| key.job == job);
        if keys.is_empty() {
            return Err(format!("there is no job {job}, and there never was").into());
        }
    }
    let path = &arguments.file;
    if path.as_os_str() == "-" {
        let mut to = BufWriter::new(out());
        write(&runtime, &*from, &keys, &mut to)?;
        return Ok(to.flush()?);
    }
    let unusable = |error: io::Error| match error.kind() {
        io::ErrorKind::AlreadyExists => format!("{} exists already; nothing is overwritten", path.display()),
        _ => format!("cannot write {}: {error}", path.display()),
    };
    let file = OpenOptions::new().write(true).create_new(true).open(path).map_err(unusable)?;
    let written = progress::shown("export", || {
        let mut to = BufWriter::new(file);
        let count = write(&runtime, &*from, &keys, &mut to)?;
        to.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()?;
        Ok::<_, CommandError>(count)
    });
    let count = written.inspect_err(|_| {
        // what is left would be recognised as incomplete
        let _left = fs::remove_file(path);
    })?;
    Ok(writeln!(out(), "{count} jobs written to {}", path.display())?)
}

fn write(runtime: &Runtime, from: &dyn Holdings, keys: &[Key], to: &mut impl Write) -> Result<u64, CommandError> {
    let (each, mut count) = (parts(keys.len()), 0);
    for key in keys {
        let line = |line: String| ready(to.write_all(line.as_bytes()));
        let written = each.run(1, || runtime.block_on(archive::export(from, key, line)));
        count += u64::from(written.map_err(|error| match error {
            ArchiveError::File(error) => CommandError::from(error),
            other => other.into(),
        })?);
    }
    to.write_all(last_line(count).as_bytes())?;
    Ok(count)
}

pub fn import(arguments: &ImportArguments) -> Result<(), CommandError> {
    match arguments.file.as_os_str() == "-" {
        true => read(io::stdin().lock(), arguments),
        false => {
            let file = File::open(&arguments.file);
            let file = file.map_err(|error| format!("cannot read {}: {error}", arguments.file.display()))?;
            progress::watched("import", || None, || read(BufReader::new(file), arguments))
        }
    }
}

fn read(from: impl io::BufRead, arguments: &ImportArguments) -> Result<(), CommandError> {
    let runtime = runtime()?;
    let to = runtime.block_on(open_holdings(&arguments.database_url, true))?;
    let stored = runtime.block_on(store(from, &*to, &arguments.file));
    // also after an error, so that the database file is complete
    let closed = runtime.block_on(to.close());
    let (stored, existed, refused) = stored?;
    writeln!(out(), "{stored} jobs stored, {existed} existed already")?;
    if !closed? {
        return Err("another program has the database open: until it has ended, the file next to the database whose \
                    name ends with -wal belongs to it"
            .into());
    }
    match refused {
        0 => Ok(()),
        refused => Err(format!("{refused} jobs were refused").into()),
    }
}

/// Returns the numbers of jobs that were stored, that existed already, and that were refused.
async fn store(from: impl io::BufRead, to: &dyn Holdings, file: &Path) -> Result<(u64, u64, u64), CommandError> {
    let mut reader = ArchiveReader::new(from);
    let (mut stored, mut existed, mut refused) = (0, 0, 0);
    loop {
        match reader.import(to, carried::check).await {
            Ok(Imported::Stored) => stored += 1,
            Ok(Imported::Exists) => existed += 1,
            Ok(Imported::Nothing) => return Ok((stored, existed, refused)),
            Err(error) if error.is_of_one_job() => {
                eprintln!("flankfit: {}, {error}", called(file));
                refused += 1;
            }
            Err(error) => {
                return Err(format!("{}, {error}; {stored} jobs before it are stored", called(file)).into());
            }
        }
    }
}

pub fn purge(arguments: &PurgeArguments) -> Result<(), CommandError> {
    let purged = runtime()?.block_on(async {
        let ids = Arc::new(OrderedIds::new());
        let store = open_shared(&arguments.database_url, ids.clone()).await?;
        let service = JobService::new(store.clone(), Arc::new(SystemClock), ids);
        let purged = purge_old(&service, arguments.older_than).await;
        store.close().await;
        purged
    });
    let (purged, failed) = purged?;
    writeln!(out(), "{purged} jobs purged")?;
    match failed {
        0 => Ok(()),
        failed => Err(format!("{failed} jobs could not be purged").into()),
    }
}

/// Returns the numbers of jobs that were purged, and that could not be.
async fn purge_old(service: &Arc<JobService>, days: u32) -> Result<(u64, u64), CommandError> {
    let since = service.now() - SignedDuration::from_hours(24 * i64::from(days));
    let (mut after, mut purged, mut failed) = (None, 0, 0);
    loop {
        let due = service.untouched(since, after.clone(), AT_A_TIME).await?;
        let Some(last) = due.last().cloned() else { return Ok((purged, failed)) };
        for Key { tenant, job } in due {
            let caller = Caller { tenant, actor: actor::RETENTION.into(), origin: Default::default() };
            let reason = format!("without activity for {days} days");
            match service.of(&caller).purge(job, reason, None).await {
                Ok(_) => purged += 1,
                Err(error) => {
                    eprintln!("flankfit: job {job}: {error}");
                    failed += 1;
                }
            }
        }
        after = Some(last);
    }
}
