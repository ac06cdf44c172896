//! Wiring: settings in, a running server out.

use std::{io, net::SocketAddr, sync::Arc};

use tokio::net::TcpListener;

use crate::{
    config::ServeSettings,
    http::{self, AppState, server},
    jobs::{Clock, Jobs, OrderedIds, Repository, SystemClock},
    store::{OpenError, Store, StoreSettings},
    telemetry,
};

/// How long WebSockets may take to end at a shutdown.
const LAST_WORDS: std::time::Duration = std::time::Duration::from_secs(5);

/// A server that listens but does not serve yet.
pub struct App {
    listener: TcpListener,
    state: AppState,
    store: Arc<Store>,
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
        let store = Store::open(StoreSettings::of_url(&settings.database_url)?, SystemClock.now()).await?;
        let store = Arc::new(store);
        let repository: Arc<dyn Repository> = store.clone();
        let jobs = Jobs::new(repository, Arc::new(SystemClock), Arc::new(OrderedIds::new()));
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

    /// Serves until `stop` is ready, then finishes what was accepted within the shutdown grace.
    pub async fn serve(self, stop: impl Future<Output = ()>) {
        let grace = self.state.settings.shutdown_grace();
        let upkeep = tokio::spawn(telemetry::upkeep());
        let state = self.state.clone();
        let stop = async {
            stop.await;
            // event streams and WebSockets would never end by themselves
            state.closing.close();
        };
        server::serve(self.listener, http::router(self.state), stop, grace).await;
        // WebSockets have left their connections; they were told to end and have nothing long to do
        let _late = tokio::time::timeout(LAST_WORDS.min(grace), state.closing.empty()).await;
        upkeep.abort();
        self.store.close().await;
    }
}
