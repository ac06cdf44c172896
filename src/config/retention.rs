//! Settings of the retention of jobs.

use std::{env, num::NonZeroU32, path::PathBuf};

use clap::Args;

use super::parse_positive;

/// A hundred years, in days: the upper bound.
const MOST_DAYS: u32 = 36_525;

#[derive(Clone, Debug, Default, PartialEq, Eq, Args)]
pub struct RetentionSettings {
    /// Days without change after which a job is archived into --archive-dir and then purged of
    /// nodes, results, texts and names. Default: never.
    #[arg(long, env = "FLANKFIT_RETAIN_BULK_DAYS", requires = "archive_dir", value_parser = parse_days)]
    pub retain_bulk_days: Option<NonZeroU32>,
    /// Folder for the archives of jobs purged by age, and for temporary files of requested
    /// archives.
    #[arg(long, env = "FLANKFIT_ARCHIVE_DIR", value_name = "DIR")]
    pub archive_dir: Option<PathBuf>,
}

fn parse_days(text: &str) -> Result<NonZeroU32, String> {
    let days = parse_positive(text).ok().filter(|days| days.get() <= MOST_DAYS);
    days.ok_or_else(|| format!("write a whole number from 1 to {MOST_DAYS}, or leave the setting out"))
}

impl RetentionSettings {
    /// Returns the folder for temporary files of archives.
    pub fn spool_dir(&self) -> PathBuf {
        self.archive_dir.clone().unwrap_or_else(env::temp_dir)
    }
}
