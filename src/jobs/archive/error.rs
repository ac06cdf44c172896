//! Why jobs are not taken elsewhere.

use std::io;

use uuid::Uuid;

use crate::jobs::outcome::RepositoryError;

#[derive(Debug, thiserror::Error)]
pub enum ArchiveError {
    #[error(transparent)]
    Store(#[from] RepositoryError),
    #[error("{0}")]
    File(#[from] io::Error),
    #[error("the file is no export of flankfit, or of another version")]
    Foreign,
    #[error("the file is cut off; nothing of it was stored")]
    Cut,
    #[error("line {line} of the file was changed; nothing of it was stored")]
    Damaged { line: u64 },
    #[error(
        "line {line} of the file is longer than {longest} bytes, as none of an export is; nothing of it was stored"
    )]
    TooLong { line: u64, longest: u64 },
    #[error("line {line} of the file, job {job}: {why}; nothing of it was stored")]
    Unreadable { line: u64, job: Uuid, why: String },
    #[error("job {0} is there already and differs; nothing was stored")]
    Differs(Uuid),
    #[error("job {job} was not stored, the jobs before it were: {error}")]
    NotStored { job: Uuid, error: RepositoryError },
    #[error(
        "all jobs are stored, but another program has the database open: until it has ended, the file next to the \
         database whose name ends with -wal belongs to it"
    )]
    StillOpen,
    #[error("there is no job {0}, and there never was")]
    NoSuchJob(Uuid),
}

impl ArchiveError {
    /// What a caller is told of an archive that could not be written.
    pub fn told(self) -> RepositoryError {
        match self {
            ArchiveError::Store(error) => error,
            ArchiveError::File(error) => RepositoryError::NotArchived(error.to_string()),
            other => RepositoryError::Failed(other.to_string()),
        }
    }
}
