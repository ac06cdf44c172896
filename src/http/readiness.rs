//! Whether the store takes what is written, asked at most once a second, however many ask.

use std::time::{Duration, Instant};

use tokio::{sync::Mutex, time::timeout};

use crate::{jobs::JobService, telemetry};

/// How long what the store said is believed.
const CHECK_INTERVAL: Duration = Duration::from_secs(1);

/// How long the store may take.
const PATIENCE: Duration = Duration::from_secs(1);

/// What the store last said, and when.
#[derive(Debug, Default)]
pub struct Readiness(Mutex<Option<(Instant, Result<(), String>)>>);

impl Readiness {
    /// Why nothing can be stored, where that is so.
    pub async fn check(&self, jobs: &JobService) -> Result<(), String> {
        // one at a time: who comes meanwhile has its outcome
        let mut last = self.0.lock().await;
        if let Some((asked, outcome)) = &*last
            && asked.elapsed() < CHECK_INTERVAL
        {
            return outcome.clone();
        }
        let asking = async {
            jobs.ping().await?;
            jobs.check_writable().await
        };
        let outcome = match timeout(PATIENCE, asking).await {
            Ok(outcome) => outcome.map_err(|error| error.to_string()),
            Err(_elapsed) => Err(format!("no answer within {} s", PATIENCE.as_secs())),
        };
        telemetry::record_store_up(outcome.is_ok());
        *last = Some((Instant::now(), outcome.clone()));
        outcome
    }
}
