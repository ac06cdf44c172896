//! Readiness by a store that is watched: how often it is asked, and how long it is waited for.

use std::{
    future::pending,
    pin::Pin,
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst},
    },
    time::{Duration, Instant},
};

use flankfit::{
    config::ServeSettings,
    http::{self, AppState},
    jobs::{
        Caller, Credentials, JobService, Keys, OrderedIds, Repository, RepositoryError, RepositoryFuture, Store,
        SystemClock, Unfit, Upkeep,
        archive::{Holdings, Key},
        audit::{Auditor, Sealed, Sealing},
    },
    store::{StoreSettings, open_sqlite},
};
use jiff::{SignedDuration, Timestamp};
use reqwest::{Client, RequestBuilder};
use tempfile::TempDir;
use tokio::{net::TcpListener, task::JoinSet, time::sleep};

use crate::harness::{figure, ready, send};

/// A store that counts the checks of its readiness, and may be silent, unfit or full.
struct Watched {
    store: Arc<dyn Store>,
    pings: AtomicUsize,
    is_silent: AtomicBool,
    unfit: Mutex<Option<Unfit>>,
    is_full: AtomicBool,
}

impl Store for Watched {
    fn of(&self, caller: &Caller) -> Arc<dyn Repository> {
        self.store.of(caller)
    }

    fn keys(&self, caller: &Caller) -> Arc<dyn Keys> {
        self.store.keys(caller)
    }

    fn credentials(&self) -> Arc<dyn Credentials> {
        self.store.credentials()
    }

    fn auditor(&self) -> Arc<dyn Auditor> {
        self.store.auditor()
    }

    fn holdings(&self) -> Arc<dyn Holdings> {
        self.store.holdings()
    }
}

impl Upkeep for Watched {
    fn forget_answers(&self, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64> {
        self.store.forget_answers(before, most)
    }

    fn forget_event_order(&self, now: Timestamp, before: Timestamp, most: u32) -> RepositoryFuture<'_, u64> {
        self.store.forget_event_order(now, before, most)
    }

    fn seal_audit(&self, sealing: Sealing) -> RepositoryFuture<'_, Option<Sealed>> {
        self.store.seal_audit(sealing)
    }

    fn untouched(&self, since: Timestamp, after: Option<Key>, most: u32) -> RepositoryFuture<'_, Vec<Key>> {
        self.store.untouched(since, after, most)
    }

    fn check_writable(&self, now: Timestamp) -> RepositoryFuture<'_, ()> {
        match self.is_full.load(SeqCst) {
            true => Box::pin(async { Err(RepositoryError::Unavailable("canary: the disk is full".to_owned())) }),
            false => self.store.check_writable(now),
        }
    }

    fn ping(&self) -> RepositoryFuture<'_, ()> {
        self.pings.fetch_add(1, SeqCst);
        if self.is_silent.load(SeqCst) {
            return Box::pin(pending());
        }
        match *self.unfit.lock().unwrap() {
            Some(unfit) => Box::pin(async move { Err(RepositoryError::Unfit(unfit)) }),
            None => self.store.ping(),
        }
    }

    fn close(&self) -> Pin<Box<dyn Future<Output = ()> + Send + '_>> {
        self.store.close()
    }
}

/// A server on such a store.
struct Server {
    store: Arc<Watched>,
    base: String,
    client: Client,
    begun: Instant,
    _directory: TempDir,
}

impl Server {
    async fn start() -> Self {
        let directory = tempfile::tempdir().unwrap();
        let settings = StoreSettings::of_file(directory.path().join("jobs.db"));
        let store = open_sqlite(settings, Arc::new(SystemClock)).await.unwrap();
        let store = Arc::new(Watched {
            store: Arc::new(store),
            pings: AtomicUsize::new(0),
            is_silent: AtomicBool::new(false),
            unfit: Mutex::new(None),
            is_full: AtomicBool::new(false),
        });
        let jobs = JobService::new(store.clone(), Arc::new(SystemClock), Arc::new(OrderedIds::new()));
        let settings = ServeSettings { workers: 1, ..ServeSettings::default() };
        let state = AppState::new(settings, jobs, None).await.unwrap();
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let base = format!("http://{}", listener.local_addr().unwrap());
        tokio::spawn(async move { axum::serve(listener, http::router(state)).await });
        let client = Client::builder().no_proxy().build().unwrap();
        Server { store, base, client, begun: Instant::now(), _directory: directory }
    }

    fn get(&self, path: &str) -> RequestBuilder {
        self.client.get(format!("{}{path}", self.base))
    }

    /// Sends so many requests at a time; each must have that status.
    async fn ask_at_once(&self, count: usize, status: u16) {
        let requests = (0..count).map(|_| send(self.get("/readyz"))).collect::<JoinSet<_>>();
        for answer in requests.join_all().await {
            assert_eq!(answer.status, status, "{}", answer.text);
        }
    }

    /// Number of checks of the store, at most one in each second that has begun.
    fn pings(&self) -> u64 {
        let pings = self.store.pings.load(SeqCst) as u64;
        let elapsed = self.begun.elapsed();
        assert!(pings <= 1 + elapsed.as_secs(), "asked {pings} times in {elapsed:?}");
        pings
    }
}

#[tokio::test]
async fn the_store_is_pinged_once_a_second_for_any_load() {
    let server = Server::start().await;
    assert_eq!(server.pings(), 0);
    server.ask_at_once(50, 200).await;
    let first = server.pings();
    assert!(first > 0);
    // and again when that is old
    while server.pings() < first + 2 {
        server.ask_at_once(5, 200).await;
        assert!(server.begun.elapsed() < Duration::from_secs(60), "the store is not asked again");
        sleep(Duration::from_millis(50)).await;
    }
}

#[tokio::test]
async fn a_store_that_does_not_answer_within_a_second_makes_the_server_not_ready() {
    let server = Server::start().await;
    ready(&server.get("/readyz")).await;
    server.store.is_silent.store(true, SeqCst);
    // what it has said is believed for a second
    let refused = loop {
        let asked = Instant::now();
        let answer = send(server.get("/readyz")).await;
        if answer.status != 200 {
            let waited = asked.elapsed();
            // with the delays of a busy machine
            assert!((1..20).contains(&waited.as_secs()), "{waited:?}");
            break answer;
        }
        assert!(server.begun.elapsed() < Duration::from_secs(60), "it is ready for ever");
        sleep(Duration::from_millis(50)).await;
    };
    refused.problem(503, "store_unavailable");
    assert_eq!(refused.header("retry-after"), "1");
    // all who ask meanwhile have one outcome
    server.ask_at_once(20, 503).await;
    let pings = server.pings();
    // and requests that need no store do not touch it
    for path in ["/healthz", "/readyz?for=compute"] {
        assert_eq!(send(server.get(path)).await.status, 200, "{path}");
    }
    assert_eq!(server.pings(), pings);
    server.store.is_silent.store(false, SeqCst);
    while send(server.get("/readyz")).await.status != 200 {
        assert!(server.begun.elapsed() < Duration::from_secs(120), "it is never ready again");
        sleep(Duration::from_millis(50)).await;
    }
    server.pings();
}

/// In words that name nothing of the database.
#[tokio::test]
async fn readiness_explains_why_nothing_can_be_stored() {
    let server = Server::start().await;
    // what the store has said is believed for a second
    let until_reported = async |why: &str| {
        let begun = Instant::now();
        loop {
            let answer = send(server.get("/readyz")).await;
            if answer.text.contains(why) {
                let detail = answer.problem(503, "store_unavailable")["detail"].to_string();
                assert!(!detail.contains("canary") && !detail.contains("4711"), "{detail}");
                return;
            }
            assert!(begun.elapsed() < Duration::from_secs(60), "{why} is not reported: {}", answer.text);
            sleep(Duration::from_millis(50)).await;
        }
    };
    for (unfit, why) in [
        (Unfit::NoSchema, "no schema yet: run `flankfit migrate`"),
        (Unfit::OldSchema, "older than this server: run `flankfit migrate`"),
        (Unfit::NewSchema(4711), "too new for this server"),
        (Unfit::Standby, "is a standby"),
        (Unfit::Misplaced, "were removed or replaced"),
        (Unfit::Clock(SignedDuration::from_secs(4711)), "clocks of this server and of the database"),
    ] {
        *server.store.unfit.lock().unwrap() = Some(unfit);
        until_reported(why).await;
    }
    *server.store.unfit.lock().unwrap() = None;
    server.store.is_full.store(true, SeqCst);
    until_reported("accepts no writes").await;
    server.store.is_silent.store(true, SeqCst);
    until_reported("does not respond").await;
}

/// Metrics report on the store although nobody requests readiness.
#[tokio::test]
async fn metrics_ask_the_store_as_readiness_does_and_wait_no_longer() {
    let server = Server::start().await;
    assert_eq!(send(server.get("/healthz")).await.status, 200);
    assert_eq!(server.pings(), 0);
    for _ in 0..20 {
        let answer = send(server.get("/metrics")).await;
        assert_eq!(answer.status, 200);
        assert!(figure(&answer.text, "flankfit_store_up").is_some(), "{}", answer.text);
    }
    assert!(server.pings() > 0);
    server.store.is_silent.store(true, SeqCst);
    // asked once more, it is silent for the second that it is given
    let before = server.pings();
    while server.pings() == before {
        let asked = Instant::now();
        let answer = send(server.get("/metrics")).await;
        assert!(answer.status == 200 && figure(&answer.text, "flankfit_store_up").is_some(), "{}", answer.text);
        // with the delays of a busy machine
        assert!(asked.elapsed() < Duration::from_secs(20), "{:?}", asked.elapsed());
        assert!(server.begun.elapsed() < Duration::from_secs(60), "the store is not asked again");
        sleep(Duration::from_millis(50)).await;
    }
    // both have one outcome
    send(server.get("/readyz")).await.problem(503, "store_unavailable");
}
