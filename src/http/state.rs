//! State shared by all handlers.

use std::{ops::Deref, sync::Arc};

use metrics_exporter_prometheus::PrometheusHandle;

use super::shutdown::Shutdown;
use crate::{
    config::{ServeSettings, StartError},
    http::{
        endpoints::{dashboard::files::Files, event_pages::EventPages},
        layers::{auth::Callers, rates::Rates, readiness::Readiness},
    },
    jobs::{JobService, RunningKeys},
    oidc::Tokens,
    pool::WorkPool,
    telemetry,
    usecases::budget::Budget,
};
use flankfit_engine::estimation::Plans;

/// Shared by every handler; cloning is cheap.
#[derive(Clone)]
pub struct AppState(Arc<Shared>);

pub struct Shared {
    pub settings: ServeSettings,
    /// Workers that compute fits.
    pub pool: WorkPool,
    /// Memory for bodies and responses.
    pub budget: Budget,
    /// Cached plans: the part of a fit that depends on places and spec only.
    pub plans: Plans,
    pub metrics: &'static PrometheusHandle,
    /// Files of the dashboard; `None` if `/` shows the documentation.
    pub dashboard: Option<Files>,
    /// Jobs of every tenant; a handler has those of its caller's (`CallerState`).
    pub jobs: Arc<JobService>,
    /// Who may call.
    pub callers: Callers,
    /// Idempotency keys whose first request is running.
    pub keys: RunningKeys,
    /// Whether the store takes what is written.
    pub readiness: Readiness,
    /// How much callers may ask for.
    pub rates: Rates,
    /// Pages of events shared by the listeners.
    pub event_pages: EventPages,
    /// For connections that stay open.
    pub shutdown: Shutdown,
}

impl AppState {
    pub async fn new(
        settings: ServeSettings,
        jobs: Arc<JobService>,
        tokens: Option<Arc<Tokens>>,
    ) -> Result<Self, StartError> {
        let rates = Rates::new(&settings);
        let budget = Budget::new(settings.body_memory);
        let pool = WorkPool::new(settings.worker_count(), settings.queue);
        let pool = pool.map_err(|error| format!("cannot start the fit workers: {error}"))?;
        let callers = Callers::of(&settings, &jobs, tokens).await;
        let callers = callers.map_err(|error| format!("cannot find out whether there are keys: {error}"))?;
        let dashboard = settings.dashboard.then(|| Files::of(settings.dashboard_dir.as_deref()));
        Ok(AppState(Arc::new(Shared {
            settings,
            pool,
            budget,
            plans: Plans::default(),
            metrics: telemetry::metrics(),
            dashboard,
            jobs,
            callers,
            keys: RunningKeys::default(),
            readiness: Readiness::default(),
            rates,
            event_pages: EventPages::default(),
            shutdown: Shutdown::default(),
        })))
    }
}

impl Deref for AppState {
    type Target = Shared;

    fn deref(&self) -> &Shared {
        &self.0
    }
}
