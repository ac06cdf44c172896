//! What every handler can reach.

use std::{future::Future, ops::Deref, pin::Pin, sync::Arc};

use metrics_exporter_prometheus::PrometheusHandle;

use crate::{config::ServeSettings, pool::WorkPool, telemetry};

/// Shared by every handler; cloning is cheap.
#[derive(Clone)]
pub struct AppState(Arc<Shared>);

pub struct Shared {
    pub settings: ServeSettings,
    /// Where fits are computed.
    pub pool: WorkPool,
    pub metrics: &'static PrometheusHandle,
    /// Asked by `/readyz`.
    pub readiness: Arc<dyn Readiness>,
}

/// Whether something that the service depends on answers.
pub trait Readiness: Send + Sync {
    /// `Err` says why not, for the log.
    fn check(&self) -> Pin<Box<dyn Future<Output = Result<(), String>> + Send + '_>>;
}

/// Depends on nothing.
pub struct AlwaysReady;

impl Readiness for AlwaysReady {
    fn check(&self) -> Pin<Box<dyn Future<Output = Result<(), String>> + Send + '_>> {
        Box::pin(std::future::ready(Ok(())))
    }
}

impl AppState {
    pub fn new(settings: ServeSettings, readiness: Arc<dyn Readiness>) -> std::io::Result<Self> {
        let pool = WorkPool::new(settings.worker_count(), settings.queue)?;
        Ok(AppState(Arc::new(Shared { settings, pool, metrics: telemetry::metrics(), readiness })))
    }
}

impl Deref for AppState {
    type Target = Shared;

    fn deref(&self) -> &Shared {
        &self.0
    }
}
