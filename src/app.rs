//! Wiring: settings in, a running server out.

mod seals;

use std::{io, net::SocketAddr, sync::Arc, time::Duration};

use tokio::{net::TcpListener, sync::oneshot, task::JoinSet, time::Instant};

use seals::SealKeeper;

use crate::{
    config::{MigrateMode, PostgresArguments, ServeSettings, StartError},
    http::{
        self, AppState,
        dashboard::files::Files,
        layers::rates,
        server::{self, Service, Tls},
    },
    jobs::{JobService, OrderedIds, Store, SystemClock, archive::Holdings, audit::Auditor},
    oidc::Tokens,
    store::{
        Migrate, PostgresError, PostgresSettings, StoreSettings, open_postgres, open_sqlite, postgres_auditor,
        postgres_holdings, sqlite_auditor, sqlite_holdings,
    },
    telemetry,
};

/// How long WebSockets may take to end at a shutdown, within the grace.
const DRAIN_TIME: Duration = Duration::from_secs(5);

/// How long the store may take to finish what it has been given. What it has not committed then was
/// not answered either, and the log of the database undoes it.
const CLOSE_TIME: Duration = Duration::from_millis(1500);

/// Time between two looks for what is kept too long.
const UPKEEP: Duration = Duration::from_secs(60);

/// Connections to the listener for operation.
const OPERATION_CONNECTIONS: usize = 64;

/// A server that listens but does not serve yet.
pub struct App {
    listener: TcpListener,
    /// For readiness and metrics, where they have a listener of their own.
    operation: Option<TcpListener>,
    tls: Option<Arc<Tls>>,
    state: AppState,
    store: Arc<dyn Store>,
    seals: Arc<SealKeeper>,
}

impl App {
    /// Binds the address and opens what the handlers need.
    pub async fn start(settings: ServeSettings) -> Result<Self, StartError> {
        let seals = Arc::new(SealKeeper::load(&settings.audit)?);
        let tls = Tls::load(&settings.tls, Arc::new(SystemClock))?;
        let listener = bind(settings.bind, "--bind or FLANKFIT_BIND").await?;
        if settings.ops_bind.is_some_and(|address| address == settings.bind && address.port() != 0) {
            let address = settings.bind;
            return Err(format!(
                "--bind and --ops-bind are both {address}; give the listener for operation a port of its own"
            )
            .into());
        }
        let operation = match settings.ops_bind {
            Some(address) => Some(bind(address, "--ops-bind or FLANKFIT_OPS_BIND").await?),
            None => None,
        };
        let ids = Arc::new(OrderedIds::new());
        let store = open_store(&settings, ids.clone()).await?;
        let jobs = JobService::new(store.clone(), Arc::new(SystemClock), ids);
        let tokens =
            Tokens::of(&settings.oidc, Arc::new(SystemClock)).map_err(|error| format!("--oidc-ca: {error}"))?;
        let state = AppState::new(settings, jobs, tokens).await?;
        state.dashboard.as_ref().map_or(Ok(()), Files::check)?;
        warn_if_open(&state);
        Ok(App { listener, operation, tls, state, store, seals })
    }

    /// The address that was bound (its port is known even when 0 was asked for).
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// The address for readiness and metrics, where it is another.
    pub fn operation_address(&self) -> Option<io::Result<SocketAddr>> {
        self.operation.as_ref().map(TcpListener::local_addr)
    }

    /// Whether clients come by TLS.
    pub fn has_tls(&self) -> bool {
        self.tls.is_some()
    }

    /// State that handlers use.
    pub fn state(&self) -> &AppState {
        &self.state
    }

    /// Serves until `stop` is ready and the drain delay over, then finishes what was accepted
    /// within the shutdown grace and cancels the rest: it returns within the grace and two seconds
    /// more, whatever runs.
    pub async fn serve(self, stop: impl Future<Output = ()>) {
        let settings = &self.state.settings;
        let (delay, grace) = (settings.drain_delay(), settings.shutdown_grace());
        let limits = server::Limits {
            connections: server::connections(settings.max_connections),
            write_timeout: settings.write_timeout(),
            grace,
        };
        let state = self.state.clone();
        // ends with this function
        let _background = background(&state, self.tls.clone(), self.seals);
        let (operation_ends, operation_ended) = oneshot::channel::<()>();
        let operation = self.operation.map(|listener| {
            let service = Service { router: http::operation_router(state.clone()), state: state.clone(), tls: None };
            let limits = server::Limits { connections: OPERATION_CONNECTIONS, grace: Duration::ZERO, ..limits };
            let ended = async {
                let _dropped = operation_ended.await;
            };
            tokio::spawn(server::serve(listener, service, ended, limits))
        });
        let (stopping, stopped) = oneshot::channel();
        let stop = async {
            stop.await;
            state.shutdown.drain();
            if !delay.is_zero() {
                tracing::info!(?delay, "about to end: not ready, connections end with their next answer");
                tokio::time::sleep(delay).await;
            }
            // event streams and WebSockets would never end by themselves
            state.shutdown.begin();
            let _sent = stopping.send(Instant::now() + grace);
        };
        let service = Service { router: http::router(self.state.clone()), state: self.state, tls: self.tls };
        server::serve(self.listener, service, stop, limits).await;
        let deadline = stopped.await.unwrap_or_else(|_| Instant::now()).min(Instant::now() + DRAIN_TIME);
        // WebSockets have left their connections; they were asked to end at once
        let _late = tokio::time::timeout_at(deadline, state.shutdown.drained()).await;
        state.pool.stop();
        drop(operation_ends);
        if let Some(operation) = operation {
            let _ended = operation.await;
        }
        if tokio::time::timeout(CLOSE_TIME, self.store.close()).await.is_err() {
            tracing::warn!("the store did not close in time");
        }
    }
}

/// Tells of a server that lets in everybody who can reach it.
fn warn_if_open(state: &AppState) {
    let settings = &state.settings;
    if !state.callers.key_required() && !settings.bind.ip().is_loopback() {
        tracing::warn!(
            address = %settings.bind,
            "no key is required: every client of this address may do everything; make keys with `flankfit keys create`"
        );
    }
}

/// The store that the scheme of the database's URL names.
pub async fn open_store(settings: &ServeSettings, ids: Arc<OrderedIds>) -> Result<Arc<dyn Store>, StartError> {
    let url = &settings.database_url;
    if !PostgresSettings::takes(url) {
        return Ok(Arc::new(open_sqlite(StoreSettings::of_url(url)?, Arc::new(SystemClock)).await?));
    }
    let store = postgres_settings(url, &settings.postgres)?;
    Ok(Arc::new(open_postgres(store, ids, Arc::new(SystemClock)).await?))
}

/// The store that the URL names, also while a server has it open.
pub async fn open_shared(url: &str, ids: Arc<OrderedIds>) -> Result<Arc<dyn Store>, StartError> {
    if PostgresSettings::takes(url) {
        let mut settings = PostgresSettings::of_url(url)?;
        settings.migrate = Migrate::Check;
        // the servers refuse settings that may lose data
        (settings.writers, settings.readers, settings.unsafe_store) = (1, 1, true);
        return Ok(Arc::new(open_postgres(settings, ids, Arc::new(SystemClock)).await?));
    }
    let mut settings = StoreSettings::of_url(url)?;
    settings.beside = true;
    Ok(Arc::new(open_sqlite(settings, Arc::new(SystemClock)).await?))
}

/// The audit in the database that the URL names, which a server may use meanwhile.
pub async fn open_auditor(url: &str) -> Result<Box<dyn Auditor>, StartError> {
    if PostgresSettings::takes(url) {
        return Ok(Box::new(postgres_auditor(&PostgresSettings::of_url(url)?)));
    }
    Ok(Box::new(sqlite_auditor(&StoreSettings::of_url(url)?).await?))
}

/// The jobs of the database that the URL names. To store jobs there, SQLite's must be in no other
/// use.
pub async fn open_holdings(url: &str, to_write: bool) -> Result<Box<dyn Holdings>, StartError> {
    if PostgresSettings::takes(url) {
        return Ok(Box::new(postgres_holdings(&PostgresSettings::of_url(url)?)));
    }
    Ok(Box::new(sqlite_holdings(&StoreSettings::of_url(url)?, to_write).await?))
}

/// How a PostgreSQL database is used.
pub fn postgres_settings(url: &str, arguments: &PostgresArguments) -> Result<PostgresSettings, PostgresError> {
    let mut settings = PostgresSettings::of_url(url)?;
    if let Some(direct) = &arguments.database_direct_url {
        settings = settings.direct(direct)?;
    }
    settings.writers = arguments.store_writers.into();
    settings.readers = arguments.database_readers.into();
    settings.patience = arguments.patience();
    settings.migrate = match arguments.migrate {
        MigrateMode::Auto => Migrate::Auto,
        MigrateMode::Check => Migrate::Check,
    };
    settings.unsafe_store = arguments.unsafe_store;
    Ok(settings)
}

async fn bind(address: SocketAddr, setting: &'static str) -> Result<TcpListener, StartError> {
    TcpListener::bind(address).await.map_err(|source| match source.kind() {
        io::ErrorKind::AddrInUse => {
            format!("{address} is taken by another program; choose another with {setting}").into()
        }
        _ => format!("cannot listen on {address}: {source}").into(),
    })
}

/// Tasks in the background of the requests, until they are dropped.
fn background(state: &AppState, tls: Option<Arc<Tls>>, seals: Arc<SealKeeper>) -> JoinSet<()> {
    let mut all = JoinSet::new();
    all.spawn(telemetry::upkeep());
    let jobs = state.clone();
    all.spawn(async move { jobs.jobs.upkeep(UPKEEP).await });
    let jobs = state.clone();
    all.spawn(async move { seals.run(&jobs.jobs).await });
    let jobs = state.clone();
    all.spawn(async move { jobs.jobs.follow_others().await });
    let keys = state.clone();
    all.spawn(async move { keys.callers.kept().write_uses().await });
    let callers = state.clone();
    all.spawn(async move { callers.callers.follow_provider().await });
    let callers = state.clone();
    all.spawn(async move {
        loop {
            tokio::time::sleep(rates::FORGET).await;
            callers.rates.forget_idle();
        }
    });
    if let Some(tls) = tls {
        all.spawn(async move { tls.follow().await });
    }
    all
}
