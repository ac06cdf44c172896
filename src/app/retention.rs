//! Jobs that nobody has touched for long: archived into a folder, and purged once the archive is
//! there, synced, and reads as it was written.

use std::{
    collections::BTreeSet,
    fs::{self, File, OpenOptions},
    io::{self, Read as _},
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use jiff::SignedDuration;
use sha2::{Digest as _, Sha256};
use uuid::Uuid;

use crate::{
    api::jobs::purge::told,
    config::RetentionSettings,
    jobs::{JobService, RepositoryError, Turn, actor, archive::Key},
};

/// Jobs that are looked up at a time.
const AT_A_TIME: u32 = 100;
/// A turn ends after it; others, or this process again, go on.
const LONGEST_TURN: Duration = Duration::from_secs(50);

/// Why the server does not start.
#[derive(Debug, thiserror::Error)]
#[error("archives of jobs cannot be kept in {folder}: {source}")]
pub struct NoArchives {
    folder: PathBuf,
    source: io::Error,
}

/// Archives and purges what is old.
pub struct Retention {
    after: SignedDuration,
    folder: PathBuf,
    /// Jobs that could not be purged. They come after all others, so that they keep none from it.
    failed: Mutex<BTreeSet<Uuid>>,
}

/// What became of a job.
enum Done {
    Purged,
    /// It was touched, purged or deleted meanwhile.
    Left,
}

impl Retention {
    /// As it is set; none where nothing is purged by its age. The folder is made where it is not
    /// there.
    pub fn of(settings: &RetentionSettings) -> Result<Option<Self>, NoArchives> {
        let (Some(days), Some(folder)) = (settings.retain_bulk_days, settings.archive_dir.clone()) else {
            return Ok(None);
        };
        let unusable = |source| NoArchives { folder: folder.clone(), source };
        fs::create_dir_all(&folder).map_err(unusable)?;
        tempfile::tempfile_in(&folder).map_err(unusable)?;
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
        let Some(Turn(_held)) = jobs.retention_turn().await? else { return Ok(0) };
        let (begun, since) = (tokio::time::Instant::now(), jobs.now() - self.after);
        let mut purged = 0;
        let failed = std::mem::take(&mut *self.failed());
        let mut due = jobs.untouched(since, AT_A_TIME.saturating_add(failed.len() as u32)).await?;
        due.sort_by_key(|key| failed.contains(&key.job));
        *self.failed() = due.iter().map(|key| key.job).filter(|job| failed.contains(job)).collect();
        for key in due {
            match self.archive_and_purge(jobs, &key).await {
                Ok(Done::Purged) => {
                    purged += 1;
                    self.failed().remove(&key.job);
                }
                Ok(Done::Left) => {}
                Err(error) => {
                    tracing::warn!(job = %key.job, %error, "a job could not be purged by its age");
                    self.failed().insert(key.job);
                }
            }
            if begun.elapsed() > LONGEST_TURN {
                break;
            }
        }
        Ok(purged)
    }

    fn failed(&self) -> std::sync::MutexGuard<'_, BTreeSet<Uuid>> {
        self.failed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    async fn archive_and_purge(&self, service: &Arc<JobService>, key: &Key) -> Result<Done, RepositoryError> {
        let jobs = service.for_retention(key);
        let folder = self.folder.join(key.tenant.as_str());
        let failed = |error: io::Error| RepositoryError::Unavailable(format!("an archive cannot be written: {error}"));
        let partial = folder.join(format!("{}.partial", key.job));
        let begun = {
            let (folder, partial) = (folder.clone(), partial.clone());
            on_disk(move || begin(&folder, &partial)).await.map_err(failed)?
        };
        let (file, archived) = jobs.archive(key.job, begun).await?;
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
        return Err(io::Error::other(format!("{} does not read as it was written", partial.display())));
    }
    fs::rename(partial, kept)?;
    for folder in [folder].into_iter().chain(folder.parent()) {
        File::open(folder)?.sync_all()?;
    }
    match digest(kept)? == *sha256 {
        true => Ok(()),
        false => Err(io::Error::other(format!("{} does not read as it was written", kept.display()))),
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
    use jiff::Timestamp;

    use super::*;
    use crate::{
        jobs::{Clock, Job, JobDraft, OrderedIds, Store},
        store::{SqliteStore, StoreSettings},
    };

    /// A clock that is put forward.
    struct Put(Mutex<Timestamp>);

    impl Put {
        fn forward(&self, days: i64) {
            let mut now = self.0.lock().unwrap();
            *now += SignedDuration::from_hours(24 * days);
        }
    }

    impl Clock for Put {
        fn now(&self) -> Timestamp {
            *self.0.lock().unwrap()
        }
    }

    struct Plant {
        place: tempfile::TempDir,
        clock: Arc<Put>,
        service: Arc<JobService>,
        store: Arc<dyn Store>,
    }

    impl Plant {
        async fn new() -> Self {
            let place = tempfile::tempdir().unwrap();
            let clock = Arc::new(Put(Mutex::new("2026-11-21T08:00:00Z".parse().unwrap())));
            let ids = Arc::new(OrderedIds::new());
            let settings = StoreSettings::of_file(place.path().join("jobs.db"));
            let store: Arc<dyn Store> =
                Arc::new(SqliteStore::open(settings, ids.clone(), clock.clone()).await.unwrap());
            let service = JobService::new(store.clone(), clock.clone(), ids);
            Plant { place, clock, service, store }
        }

        fn retention(&self, days: u32) -> Retention {
            let settings = RetentionSettings {
                retain_bulk_days: Some(days.try_into().unwrap()),
                archive_dir: Some(self.place.path().join("archives")),
            };
            Retention::of(&settings).unwrap().unwrap()
        }

        async fn job(&self) -> Arc<Job> {
            let key = Key { tenant: Default::default(), job: Default::default() };
            let draft = JobDraft {
                name: "wheel".into(),
                part_number: None,
                serial_number: None,
                machine: None,
                gear: None,
                requirements: None,
                tags: Default::default(),
            };
            self.service.for_retention(&key).create_job(draft, None).await.unwrap()
        }

        async fn is_purged(&self, job: &Job) -> bool {
            let key = Key { tenant: Default::default(), job: job.id };
            self.service.for_retention(&key).job(job.id).await.unwrap().purged_at.is_some()
        }

        /// Files of the folder of the tenant.
        fn files(&self) -> Vec<PathBuf> {
            let folder = self.place.path().join("archives/default");
            let mut all: Vec<_> = fs::read_dir(folder).into_iter().flatten().map(|file| file.unwrap().path()).collect();
            all.sort();
            all
        }
    }

    #[tokio::test]
    async fn what_nobody_touches_is_archived_and_then_purged() {
        let plant = Plant::new().await;
        let retention = plant.retention(30);
        let old = plant.job().await;
        plant.clock.forward(20);
        let young = plant.job().await;
        assert_eq!(retention.turn(&plant.service).await.unwrap(), 0);
        plant.clock.forward(11);
        assert_eq!(retention.turn(&plant.service).await.unwrap(), 1);
        assert!(plant.is_purged(&old).await && !plant.is_purged(&young).await);
        // the archive is there under its digest, and is the job's
        let [file] = &plant.files()[..] else { panic!("{:?}", plant.files()) };
        let name = file.file_name().unwrap().to_str().unwrap();
        assert_eq!(name, format!("{}-{}.jsonl.zst", old.id, told(&digest(file).unwrap())));
        let listed = crate::jobs::archive::listed(File::open(file).unwrap()).unwrap();
        assert_eq!((listed.len(), listed[0].0.job), (1, old.id));
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            assert_eq!(file.metadata().unwrap().permissions().mode() & 0o777, 0o600);
        }
        // once
        assert_eq!(retention.turn(&plant.service).await.unwrap(), 0);
        assert_eq!(plant.files().len(), 1);
        plant.clock.forward(20);
        assert_eq!(retention.turn(&plant.service).await.unwrap(), 1);
        assert_eq!(plant.files().len(), 2);
        plant.store.close().await;
    }

    #[tokio::test]
    async fn without_a_file_that_reads_as_it_was_written_nothing_is_purged() {
        let plant = Plant::new().await;
        let retention = plant.retention(1);
        let job = plant.job().await;
        plant.clock.forward(2);
        // a file stands where the folder of the tenant would
        let folder = plant.place.path().join("archives/default");
        fs::write(&folder, "").unwrap();
        assert_eq!(retention.turn(&plant.service).await.unwrap(), 0);
        assert!(!plant.is_purged(&job).await);
        fs::remove_file(&folder).unwrap();
        // a disk that takes everything and keeps nothing
        fs::create_dir(&folder).unwrap();
        let partial = folder.join(format!("{}.partial", job.id));
        std::os::unix::fs::symlink("/dev/null", &partial).unwrap();
        assert_eq!(retention.turn(&plant.service).await.unwrap(), 0);
        assert!(!plant.is_purged(&job).await);
        assert_eq!(plant.files(), std::slice::from_ref(&partial), "nothing has the name of an archive");
        fs::remove_file(partial).unwrap();
        assert_eq!(retention.turn(&plant.service).await.unwrap(), 1);
        assert!(plant.is_purged(&job).await);
        plant.store.close().await;
    }

    #[tokio::test]
    async fn jobs_that_cannot_be_purged_keep_no_other_from_it() {
        let plant = Plant::new().await;
        let retention = plant.retention(1);
        let folder = plant.place.path().join("archives/default");
        fs::create_dir(&folder).unwrap();
        for _ in 0..AT_A_TIME {
            let job = plant.job().await;
            // a disk that takes everything and keeps nothing
            std::os::unix::fs::symlink("/dev/null", folder.join(format!("{}.partial", job.id))).unwrap();
        }
        plant.clock.forward(1);
        let last = plant.job().await;
        plant.clock.forward(2);
        assert_eq!(retention.turn(&plant.service).await.unwrap(), 0);
        assert_eq!(retention.turn(&plant.service).await.unwrap(), 1);
        assert!(plant.is_purged(&last).await);
        plant.store.close().await;
    }

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
        assert!(of(Some(1), Some(&file)).is_err_and(|error| error.to_string().contains("cannot be kept in")));
        assert!(matches!(of(None, Some(place.path())), Ok(None)));
        assert!(matches!(of(Some(1), Some(&place.path().join("new"))), Ok(Some(_))));
        assert!(place.path().join("new").is_dir());
    }
}
