//! Checks that the files of the open database are still the ones at its path.
//!
//! A file that was removed or replaced stays open for this process: SQLite continues to write to
//! it, and everything written is lost when the process ends. So the writer checks before it writes,
//! and again before it acknowledges a write.

use std::path::{Path, PathBuf};

/// The database and its log as they were opened.
#[derive(Debug, Default)]
pub struct InPlace(Vec<(PathBuf, Identity)>);

/// Device and inode number of a file.
type Identity = (u64, u64);

impl InPlace {
    /// Takes the identities of the files of a database that has just been opened. (Files that do
    /// not exist in the file system are not checked: the storage is of another kind.)
    pub fn of(database: &Path) -> Self {
        let log = std::fs::canonicalize(database).map(|real| {
            let mut name = real.into_os_string();
            name.push("-wal");
            PathBuf::from(name)
        });
        let files = [Some(database.to_path_buf()), log.ok()].into_iter().flatten();
        InPlace(files.filter_map(|file| Some((identity(&file)?, file))).map(|(now, file)| (file, now)).collect())
    }

    /// Returns the first file that was removed or replaced.
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

/// On other systems an open file can be neither removed nor replaced.
#[cfg(not(unix))]
fn identity(file: &Path) -> Option<Identity> {
    file.exists().then_some((0, 0))
}
