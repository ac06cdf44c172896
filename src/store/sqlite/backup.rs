//! A copy of the database, consistent while the service goes on writing.

use std::{
    fs::{self, File, OpenOptions},
    io,
    path::{Path, PathBuf},
};

use sqlx::Connection;

use super::{error::OpenError, open::StoreSettings};

/// Why there is no backup.
#[derive(Debug, thiserror::Error)]
pub enum BackupError {
    #[error(transparent)]
    Source(#[from] OpenError),
    #[error(
        "there is no database at {path}, so nothing to copy; name the one that the server uses with --database-url or \
         FLANKFIT_DATABASE_URL", path = .0.display()
    )]
    NoSource(PathBuf),
    #[error("{path} exists already; a backup overwrites nothing", path = .0.display())]
    Exists(PathBuf),
    #[error("cannot write {path}: {source}", path = path.display())]
    Target { path: PathBuf, source: io::Error },
    #[error("the copy to {path} failed: {source}", path = path.display())]
    Copy { path: PathBuf, source: sqlx::Error },
    #[error("the copy at {path} is damaged: {finding}", path = path.display())]
    Damaged { path: PathBuf, finding: String },
}

/// Returns the path of a copy while it is made.
pub fn unfinished(target: &Path) -> PathBuf {
    let mut partial = target.as_os_str().to_owned();
    partial.push(".partial");
    PathBuf::from(partial)
}

/// Copies the database to a new file, in one read transaction (so it is one state of it), checks
/// the copy and syncs it. The file appears under its name only when it is whole.
pub async fn backup(settings: &StoreSettings, target: &Path) -> Result<(), BackupError> {
    if !settings.path().exists() {
        return Err(BackupError::NoSource(settings.path()));
    }
    let mut source = settings.open_existing().await?;
    // Reserving the name refuses an existing file without a gap between looking and writing.
    match OpenOptions::new().write(true).create_new(true).open(target) {
        Ok(_) => {}
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => return Err(BackupError::Exists(target.into())),
        Err(source) => return Err(BackupError::Target { path: target.into(), source }),
    }
    let partial = unfinished(target);
    let copied = copy(&mut source, &partial).await.and_then(|()| {
        let written = |source| BackupError::Target { path: target.into(), source };
        File::open(&partial).and_then(|file| file.sync_all()).map_err(written)?;
        fs::rename(&partial, target).map_err(written)?;
        let directory = target.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        File::open(directory).and_then(|directory| directory.sync_all()).map_err(written)
    });
    if copied.is_err() {
        // The reservation and the half copy are ours; that they may be gone already is no matter.
        let _ = fs::remove_file(&partial);
        let _ = fs::remove_file(target);
    }
    let _ = source.close().await;
    copied
}

async fn copy(source: &mut sqlx::SqliteConnection, to: &Path) -> Result<(), BackupError> {
    let failed = |source| BackupError::Copy { path: to.into(), source };
    let name = to.to_str().ok_or_else(|| BackupError::Target {
        path: to.into(),
        source: io::Error::new(io::ErrorKind::InvalidFilename, "the name is not UTF-8"),
    })?;
    sqlx::query("VACUUM INTO ?").bind(name).execute(source).await.map_err(failed)?;
    let mut copy = StoreSettings::of_file(to).open_existing().await?;
    let finding: String = sqlx::query_scalar("PRAGMA integrity_check(1)").fetch_one(&mut copy).await.map_err(failed)?;
    copy.close().await.map_err(failed)?;
    if finding == "ok" { Ok(()) } else { Err(BackupError::Damaged { path: to.into(), finding }) }
}
