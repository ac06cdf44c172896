//! Jobs without activity for long: archived into a folder, and purged once the archive is
//! there, synced, and reads as it was written.

use std::{
    collections::BTreeMap,
    fs::{self, File, OpenOptions},
    io::{self, Read as _},
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use jiff::{SignedDuration, Timestamp};
use sha2::{Digest as _, Sha256};
use uuid::Uuid;

use crate::{
    api::jobs::purge::told,
    config::RetentionSettings,
    jobs::{JobService, RepositoryError, actor, archive::Key},
};

/// A turn ends after it; others, or this process again, go on.
const LONGEST_TURN: Duration = Duration::from_secs(50);

/// Why archives cannot be written.
#[derive(Debug, thiserror::Error)]
#[error(
    "archives of jobs cannot be kept in {folder}: {source}; make it a folder that the server may write to, or name \
     another with --archive-dir"
)]
pub struct NoArchives {
    folder: PathBuf,
    source: io::Error,
}

/// Archives and purges what is old.
pub struct Retention {
    after: SignedDuration,
    folder: PathBuf,
    /// Jobs that could not be purged. They come after all others, so that they keep none from it.
    failed: Mutex<BTreeMap<Uuid, Failure>>,
}

/// A job is archived anew for each try, so one that fails for good is tried less and less often.
#[derive(Clone, Copy)]
struct Failure {
    /// When it is tried again.
    again: Timestamp,
    /// How long that was waited for.
    waited: SignedDuration,
}

impl Failure {
    const FIRST: SignedDuration = SignedDuration::from_mins(1);
    const LONGEST: SignedDuration = SignedDuration::from_hours(24);

    fn after(last: Option<&Failure>, now: Timestamp) -> Self {
        let waited = last.map_or(Self::FIRST, |last| Self::LONGEST.min(last.waited * 2));
        Failure { again: now + waited, waited }
    }
}

/// What became of a job.
enum Done {
    Purged,
    /// It was touched, purged or deleted meanwhile.
    Left,
}

impl Retention {
    /// Jobs that are looked up at a time.
    pub const AT_A_TIME: u32 = 100;

    /// Returns the retention of the settings; `None` if nothing is purged by age. A configured
    /// folder must exist: creating it could put it on the mount point of a share that is not
    /// mounted.
    pub fn of(settings: &RetentionSettings) -> Result<Option<Self>, NoArchives> {
        let Some(folder) = settings.archive_dir.clone() else {
            // most archives fit into memory
            if let Err(error) = takes_files(&settings.spool_dir()) {
                tracing::warn!(%error, "archives of more than 1 MiB will be refused");
            }
            return Ok(None);
        };
        takes_files(&folder)?;
        let Some(days) = settings.retain_bulk_days else { return Ok(None) };
        Ok(Some(Retention {
            after: SignedDuration::from_hours(24 * i64::from(days.get())),
            folder,
            failed: Mutex::default(),
        }))
    }

    /// Never ends.
    pub async fn run(&self, jobs: &Arc<JobService>, every: Duration) {
        loop {
            tokio::time::sleep(every).await;
            match self.turn(jobs).await {
                Ok(0) => {}
                Ok(purged) => tracing::info!(purged, "jobs were archived and purged by their age"),
                Err(error) => tracing::warn!(%error, "jobs could not be purged by their age"),
            }
        }
    }

    /// Purges what is due, if it is this process's turn; answers how many jobs.
    pub async fn turn(&self, jobs: &Arc<JobService>) -> Result<u64, RepositoryError> {
        let Some(turn) = jobs.retention_turn().await? else { return Ok(0) };
        let purged = self.purge_due(jobs).await;
        turn.end().await;
        purged
    }

    async fn purge_due(&self, jobs: &Arc<JobService>) -> Result<u64, RepositoryError> {
        let (begun, now) = (tokio::time::Instant::now(), jobs.now());
        let mut purged = 0;
        for key in self.due(jobs, now).await? {
            match self.archive_and_purge(jobs, &key).await {
                Ok(Done::Purged) => {
                    purged += 1;
                    self.failed().remove(&key.job);
                }
                Ok(Done::Left) => {}
                Err(error) => {
                    tracing::warn!(job = %key.job, %error, "a job could not be purged by its age");
                    let mut failed = self.failed();
                    let failure = Failure::after(failed.get(&key.job), now);
                    failed.insert(key.job, failure);
                }
            }
            if begun.elapsed() > LONGEST_TURN {
                break;
            }
        }
        Ok(purged)
    }

    /// Jobs to be purged now, those that could not be purged before last.
    async fn due(&self, jobs: &JobService, now: Timestamp) -> Result<Vec<Key>, RepositoryError> {
        let most = Self::AT_A_TIME.saturating_add(self.failed().len() as u32);
        let mut due = jobs.untouched(now - self.after, most).await?;
        let mut failed = self.failed();
        failed.retain(|job, _| due.iter().any(|key| key.job == *job));
        due.retain(|key| failed.get(&key.job).is_none_or(|failure| failure.again <= now));
        due.sort_by_key(|key| failed.contains_key(&key.job));
        Ok(due)
    }

    fn failed(&self) -> std::sync::MutexGuard<'_, BTreeMap<Uuid, Failure>> {
        self.failed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    async fn archive_and_purge(&self, service: &Arc<JobService>, key: &Key) -> Result<Done, RepositoryError> {
        let jobs = service.for_retention(key);
        let folder = self.folder.join(key.tenant.as_str());
        let failed = |error: io::Error| RepositoryError::NotArchived(format!("{}: {error}", self.folder.display()));
        let partial = folder.join(format!("{}.partial", key.job));
        let begun = {
            let (folder, partial) = (folder.clone(), partial.clone());
            on_disk(move || begin(&folder, &partial)).await.map_err(failed)?
        };
        let (file, archived) = jobs.archive(key.job, begun).await.map_err(|error| match error {
            RepositoryError::NotArchived(why) => failed(io::Error::other(why)),
            error => error,
        })?;
        let kept = folder.join(format!("{}-{}.jsonl.zst", key.job, told(&archived.sha256)));
        let name = kept.clone();
        on_disk(move || keep(&file, &partial, &folder, &name, &archived.sha256)).await.map_err(failed)?;
        match jobs.purge(key.job, actor::RETENTION.to_owned(), archived.sha256, None).await {
            Ok(_) => Ok(Done::Purged),
            Err(RepositoryError::ArchiveDiffers | RepositoryError::HasTasks(_) | RepositoryError::NotFound(_)) => {
                // the archive is of a job that has gone on
                on_disk(move || fs::remove_file(&kept)).await.map_err(failed)?;
                Ok(Done::Left)
            }
            // by another process, whose archive is this one
            Err(RepositoryError::Purged { .. }) => Ok(Done::Left),
            Err(error) => Err(error),
        }
    }
}

/// Tries whether a file can be made there.
fn takes_files(folder: &Path) -> Result<(), NoArchives> {
    let tried = tempfile::tempfile_in(folder);
    tried.map(drop).map_err(|source| NoArchives { folder: folder.to_owned(), source })
}

async fn on_disk<T: Send + 'static>(work: impl FnOnce() -> io::Result<T> + Send + 'static) -> io::Result<T> {
    tokio::task::spawn_blocking(work).await.unwrap_or_else(|lost| Err(io::Error::other(lost)))
}

/// An empty file, which its owner alone can read.
fn begin(folder: &Path, partial: &Path) -> io::Result<File> {
    fs::create_dir_all(folder)?;
    let mut options = OpenOptions::new();
    options.write(true).create(true).truncate(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(partial)
}

/// Syncs the file, reads it again, and only then gives it its name, which is synced too.
fn keep(file: &File, partial: &Path, folder: &Path, kept: &Path, sha256: &[u8; 32]) -> io::Result<()> {
    file.sync_all()?;
    if digest(partial)? != *sha256 {
        return Err(io::Error::other(format!("{} does not read back identically", partial.display())));
    }
    fs::rename(partial, kept)?;
    for folder in [folder].into_iter().chain(folder.parent()) {
        File::open(folder)?.sync_all()?;
    }
    match digest(kept)? == *sha256 {
        true => Ok(()),
        false => Err(io::Error::other(format!("{} does not read back identically", kept.display()))),
    }
}

fn digest(file: &Path) -> io::Result<[u8; 32]> {
    let (mut file, mut digest, mut piece) = (File::open(file)?, Sha256::new(), vec![0; 256 << 10]);
    loop {
        match file.read(&mut piece)? {
            0 => return Ok(digest.finalize().into()),
            read => digest.update(&piece[..read]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_takes_nothing_is_told_at_the_start() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("file");
        fs::write(&file, "").unwrap();
        let of = |days: Option<u32>, folder: Option<&Path>| {
            let archive_dir = folder.map(Path::to_path_buf);
            Retention::of(&RetentionSettings {
                retain_bulk_days: days.and_then(|days| days.try_into().ok()),
                archive_dir,
            })
        };
        for days in [Some(1), None] {
            let said = of(days, Some(&file)).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(said.contains(&format!("cannot be kept in {}: ", file.display())), "{said}");
            assert!(said.contains("--archive-dir"), "{said}");
        }
        assert!(matches!(of(None, Some(place.path())), Ok(None)));
        assert!(matches!(of(Some(1), Some(place.path())), Ok(Some(_))));
        // mount point of a share that is not mounted yet
        let missing = place.path().join("missing");
        let said = of(Some(1), Some(&missing)).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(said.contains("missing: No such file") && !missing.exists(), "{said}");
    }
}
