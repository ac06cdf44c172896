//! One process writes a database at a time.
//!
//! SQLite would let two processes write in turns, and what is stored is checked against the
//! database. But which idempotency keys are being worked on, and who is to be woken when a job goes
//! on, each process knows of itself only. So the writer holds a lock on a file next to the database
//! (`jobs.db.lock`), which the operating system takes back when the process dies. The lock
//! is not on the database itself: closing a second handle of that file would drop SQLite's own
//! locks. Who only reads (a backup, a shell) needs no lock.

use std::{
    fs::{self, File, OpenOptions, TryLockError},
    io,
    path::{Path, PathBuf},
    time::Duration,
};

use super::error::OpenError;

/// A server that is ending gives the lock up within moments; a restart waits for it this long.
const ATTEMPTS: u32 = 20;
const PAUSE: Duration = Duration::from_millis(100);

/// Takes the lock of a database; it is held until the file is dropped. `None` where the file system
/// knows no locks.
pub async fn take(database: &Path) -> Result<Option<File>, OpenError> {
    refuse_linked(database)?;
    let path = lock_file(database);
    let file = OpenOptions::new().create(true).truncate(false).write(true).open(&path).map_err(|error| {
        let path = database.to_path_buf();
        match error.kind() {
            io::ErrorKind::ReadOnlyFilesystem => OpenError::ReadOnly { path },
            _ => OpenError::CannotOpen { path },
        }
    })?;
    for attempt in 1..=ATTEMPTS {
        match file.try_lock() {
            Ok(()) => return Ok(Some(file)),
            Err(TryLockError::WouldBlock) if attempt < ATTEMPTS => tokio::time::sleep(PAUSE).await,
            Err(TryLockError::WouldBlock) => break,
            Err(TryLockError::Error(error)) => {
                tracing::warn!(%error, lock = %path.display(), "the database cannot be locked against a second writer");
                return Ok(None);
            }
        }
    }
    Err(OpenError::InUse { path: database.to_path_buf(), lock: path })
}

/// Refuses a file that has another name (a hard link): log and lock would exist next to only one of
/// the names.
fn refuse_linked(database: &Path) -> Result<(), OpenError> {
    #[cfg(unix)]
    if fs::metadata(database).is_ok_and(|file| std::os::unix::fs::MetadataExt::nlink(&file) > 1) {
        return Err(OpenError::Linked { path: database.to_path_buf() });
    }
    Ok(())
}

/// Returns `jobs.db.lock`, next to the file that the path leads to in the end: two names of one
/// database are one database.
fn lock_file(database: &Path) -> PathBuf {
    let real = fs::canonicalize(database).or_else(|error| match (database.parent(), database.file_name()) {
        (Some(parent), Some(name)) if !parent.as_os_str().is_empty() => Ok(fs::canonicalize(parent)?.join(name)),
        _ => Err(error),
    });
    let mut name = real.unwrap_or_else(|_| database.to_path_buf()).into_os_string();
    name.push(".lock");
    PathBuf::from(name)
}
