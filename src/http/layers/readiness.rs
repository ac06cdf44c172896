//! Whether the store takes what is written, asked at most once a second, however many ask.

use std::time::{Duration, Instant};

use tokio::{
    sync::Mutex,
    time::{self, timeout_at},
};

use crate::{
    jobs::{JobService, RepositoryError, Unfit},
    telemetry,
};

/// How long what the store said is believed.
const CHECK_INTERVAL: Duration = Duration::from_secs(1);

/// How long the store may take.
const PATIENCE: Duration = Duration::from_secs(1);

/// Why nothing can be stored: one of a few sentences for whoever asks, which name nothing of the
/// database, and all of it for the log.
#[derive(Clone, Debug)]
pub struct Unready {
    pub message: &'static str,
    pub cause: String,
}

const SILENT: &str = "The store does not respond; the log says more.";
const UNWRITABLE: &str = "The store responds, but accepts no writes; the log has details.";

fn message_of(unfit: Unfit) -> &'static str {
    match unfit {
        Unfit::NoSchema => "The database has no schema yet: run `flankfit migrate`.",
        Unfit::OldSchema => "The schema of the database is older than this server: run `flankfit migrate`.",
        Unfit::NewSchema(_) => "The schema of the database is too new for this server: start a later version.",
        Unfit::Standby => "The database is a standby, which accepts no writes.",
        Unfit::Misplaced => {
            "The files of the database were removed or replaced while the server is running; the log has instructions."
        }
        Unfit::Clock(_) => "The clocks of this server and of the database are too far apart.",
    }
}

/// Last state of the store, and when it was checked.
#[derive(Debug, Default)]
pub struct Readiness(Mutex<Option<(Instant, Result<(), Unready>)>>);

impl Readiness {
    /// Why nothing can be stored, where that is so.
    pub async fn check(&self, jobs: &JobService) -> Result<(), Unready> {
        // one at a time: who comes meanwhile has its outcome
        let mut last = self.0.lock().await;
        if let Some((asked, outcome)) = &*last
            && asked.elapsed() < CHECK_INTERVAL
        {
            return outcome.clone();
        }
        let until = time::Instant::now() + PATIENCE;
        let mut outcome = answered(until, SILENT, jobs.ping()).await;
        if outcome.is_ok() {
            outcome = answered(until, UNWRITABLE, jobs.check_writable()).await;
        }
        metrics::gauge!(telemetry::STORE_UP).set(f64::from(outcome.is_ok()));
        *last = Some((Instant::now(), outcome.clone()));
        outcome
    }
}

/// Returns the state that the store reports until then, or the message for one that reports none.
async fn answered(
    until: time::Instant,
    otherwise: &'static str,
    asking: impl Future<Output = Result<(), RepositoryError>>,
) -> Result<(), Unready> {
    match timeout_at(until, asking).await {
        Ok(Ok(())) => Ok(()),
        Ok(Err(RepositoryError::Unfit(unfit))) => Err(Unready { message: message_of(unfit), cause: unfit.to_string() }),
        Ok(Err(error)) => Err(Unready { message: otherwise, cause: error.to_string() }),
        Err(_elapsed) => {
            Err(Unready { message: otherwise, cause: format!("no response within {} s", PATIENCE.as_secs()) })
        }
    }
}
