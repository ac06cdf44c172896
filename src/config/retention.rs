//! What becomes of old jobs.

use std::{env, num::NonZeroU32, path::PathBuf};

use clap::Args;

use super::parse_positive;

#[derive(Clone, Debug, Default, PartialEq, Eq, Args)]
pub struct RetentionSettings {
    /// Days after which a job that nobody has touched is archived into --archive-dir and then
    /// purged of nodes, results, texts and names. Without it never.
    #[arg(long, env = "FLANKFIT_RETAIN_BULK_DAYS", requires = "archive_dir", value_parser = parse_positive)]
    pub retain_bulk_days: Option<NonZeroU32>,
    /// Folder for the archives of jobs that are purged by their age; archives that are asked for
    /// are put together there before they are sent, without a name.
    #[arg(long, env = "FLANKFIT_ARCHIVE_DIR", value_name = "DIR")]
    pub archive_dir: Option<PathBuf>,
}

impl RetentionSettings {
    /// Where archives are put together.
    pub fn spool_dir(&self) -> PathBuf {
        self.archive_dir.clone().unwrap_or_else(env::temp_dir)
    }
}
