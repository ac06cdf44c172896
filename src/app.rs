//! Wiring: settings in, a running server out.

use std::{io, net::SocketAddr, sync::Arc, time::Duration};

use tokio::{net::TcpListener, sync::oneshot, time::Instant};

use crate::{
    config::ServeSettings,
    http::{self, AppState, server},
    jobs::{Clock, JobService, OrderedIds, Store, SystemClock},
    store::{OpenError, SqliteStore, StoreSettings},
    telemetry,
};

/// How long WebSockets may take to end at a shutdown, within the grace.
const DRAIN_TIME: Duration = Duration::from_secs(5);

/// How long the store may take to finish what it has been given. What it has not committed then was
/// not answered either, and the log of the database undoes it.
const CLOSE_TIME: Duration = Duration::from_millis(1500);

/// Time between two looks for what is kept too long.
const UPKEEP: std::time::Duration = std::time::Duration::from_secs(3600);

/// A server that listens but does not serve yet.
pub struct App {
    listener: TcpListener,
    state: AppState,
    store: Arc<dyn Store>,
}

/// Why the server did not start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    #[error("{address} is taken by another program; choose another with --bind or FLANKFIT_BIND")]
    AddressTaken { address: SocketAddr },
    #[error("cannot listen on {address}: {source}")]
    Listen { address: SocketAddr, source: io::Error },
    #[error(transparent)]
    Store(#[from] OpenError),
    #[error("cannot start the fit workers: {0}")]
    Workers(io::Error),
}

impl App {
    /// Binds the address and opens what the handlers need.
    pub async fn start(settings: ServeSettings) -> Result<Self, StartError> {
        let address = settings.bind;
        let listener = TcpListener::bind(address).await.map_err(|source| match source.kind() {
            io::ErrorKind::AddrInUse => StartError::AddressTaken { address },
            _ => StartError::Listen { address, source },
        })?;
        let store = SqliteStore::open(StoreSettings::of_url(&settings.database_url)?, SystemClock.now()).await?;
        let store: Arc<dyn Store> = Arc::new(store);
        let jobs = JobService::new(store.clone(), Arc::new(SystemClock), Arc::new(OrderedIds::new()));
        let state = AppState::new(settings, jobs).map_err(StartError::Workers)?;
        Ok(App { listener, state, store })
    }

    /// The address that was bound (its port is known even when 0 was asked for).
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// What the handlers reach.
    pub fn state(&self) -> &AppState {
        &self.state
    }

    /// Serves until `stop` is ready, then finishes what was accepted within the shutdown grace and
    /// cancels the rest: it returns within the grace and two seconds, whatever runs.
    pub async fn serve(self, stop: impl Future<Output = ()>) {
        let settings = &self.state.settings;
        let grace = settings.shutdown_grace();
        let limits = server::Limits {
            connections: server::connections(settings.max_connections),
            write_timeout: settings.write_timeout(),
            grace,
        };
        let upkeep = tokio::spawn(telemetry::upkeep());
        let state = self.state.clone();
        let forgetting = tokio::spawn({
            let state = state.clone();
            async move { state.jobs.upkeep(UPKEEP).await }
        });
        let (stopping, stopped) = oneshot::channel();
        let stop = async {
            stop.await;
            // event streams and WebSockets would never end by themselves
            state.shutdown.begin();
            let _sent = stopping.send(Instant::now() + grace);
        };
        server::serve(self.listener, http::router(self.state), stop, limits).await;
        let deadline = stopped.await.unwrap_or_else(|_| Instant::now()).min(Instant::now() + DRAIN_TIME);
        // WebSockets have left their connections; they were told to end at once
        let _late = tokio::time::timeout_at(deadline, state.shutdown.drained()).await;
        state.pool.stop();
        upkeep.abort();
        forgetting.abort();
        if tokio::time::timeout(CLOSE_TIME, self.store.close()).await.is_err() {
            tracing::warn!("the store did not close in time");
        }
    }
}
