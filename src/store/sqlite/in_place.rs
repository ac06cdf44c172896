//! Whether the files of the open database are still the ones at its path.
//!
//! A file that was removed or replaced stays open for this process: SQLite goes on writing it, and
//! all of that is lost when the process ends. So the writer compares before it writes, and again
//! before it says that something is stored.

use std::path::{Path, PathBuf};

/// The database and its log as they were opened.
#[derive(Debug, Default)]
pub struct InPlace(Vec<(PathBuf, Identity)>);

/// Device and number of a file.
type Identity = (u64, u64);

impl InPlace {
    /// Of a database that has just been opened. (A file that the file system does not show is one
    /// of another kind of storage.)
    pub fn of(database: &Path) -> Self {
        let log = std::fs::canonicalize(database).map(|real| {
            let mut name = real.into_os_string();
            name.push("-wal");
            PathBuf::from(name)
        });
        let files = [Some(database.to_path_buf()), log.ok()].into_iter().flatten();
        InPlace(files.filter_map(|file| Some((identity(&file)?, file))).map(|(now, file)| (file, now)).collect())
    }

    /// The first file that was removed or replaced.
    pub fn missing(&self) -> Option<&Path> {
        let changed = self.0.iter().find(|(file, opened)| identity(file) != Some(*opened));
        changed.map(|(file, _)| file.as_path())
    }
}

#[cfg(unix)]
fn identity(file: &Path) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt as _;
    let found = std::fs::metadata(file).ok()?;
    Some((found.dev(), found.ino()))
}

/// Elsewhere an open file can be neither removed nor replaced.
#[cfg(not(unix))]
fn identity(file: &Path) -> Option<Identity> {
    file.exists().then_some((0, 0))
}
