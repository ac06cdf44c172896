//! Whether the store takes what is written, asked at most once a second, however many ask.

use std::time::{Duration, Instant};

use tokio::sync::Mutex;

use crate::jobs::{JobService, RepositoryError};

/// How long it is believed that the disk takes what is written.
const CHECK_INTERVAL: Duration = Duration::from_secs(1);

/// When the store last took something.
#[derive(Debug, Default)]
pub struct Readiness(Mutex<Option<Instant>>);

impl Readiness {
    pub async fn check(&self, jobs: &JobService) -> Result<(), RepositoryError> {
        jobs.ping().await?;
        // one at a time: who comes meanwhile has its outcome
        let mut taken = self.0.lock().await;
        if taken.is_none_or(|last| last.elapsed() >= CHECK_INTERVAL) {
            jobs.check_writable().await?;
            *taken = Some(Instant::now());
        }
        Ok(())
    }
}
