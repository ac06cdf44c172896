//! PostgreSQL behind a proxy that cuts connections: what was acknowledged is stored once, and what
//! is not known is said to be unknown.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

use flankfit::{
    jobs::{OrderedIds, Repository, RepositoryError, Store as _, SystemClock},
    store::{PostgresSettings, SqlStore, open_postgres},
};
use tokio::{
    io::{AsyncReadExt as _, AsyncWriteExt as _, copy},
    net::{TcpListener, TcpStream, UnixStream},
};

use crate::{
    server::Server,
    support::{Values, WHOLE, caller, receipt},
};

/// Messages of the server when something is done.
const BEGUN: &[u8] = b"BEGIN\0";
const COMMITTED: &[u8] = b"COMMIT\0";
/// For stores that get through: a busy machine may take long to do what was cut again.
const PATIENCE: Duration = Duration::from_secs(60);

/// A way to a new database on the server of the tests.
pub struct Proxy {
    port: u16,
    name: String,
    pub cut: Arc<Cut>,
}

/// Moment at which connections are cut.
#[derive(Default)]
pub struct Cut {
    /// Before the client hears that a transaction has begun, or that it is committed; once.
    begun: AtomicBool,
    pub committed: AtomicBool,
    /// New connections are closed at once.
    closed: AtomicBool,
    /// And so they are after the next cut.
    for_good: AtomicBool,
}

impl Cut {
    /// True if what the server says is kept from the client.
    fn falls(&self, said: &[u8]) -> bool {
        let says = |tag: &[u8]| said.windows(tag.len()).any(|part| part == tag);
        let falls = says(BEGUN) && self.begun.swap(false, Ordering::SeqCst)
            || says(COMMITTED) && self.committed.swap(false, Ordering::SeqCst);
        if falls && self.for_good.load(Ordering::SeqCst) {
            self.closed.store(true, Ordering::SeqCst);
        }
        falls
    }
}

impl Proxy {
    pub async fn new() -> Self {
        let server = Server::shared();
        let (name, socket) = (server.with_schema().await, server.folder.join(".s.PGSQL.5432"));
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let port = listener.local_addr().unwrap().port();
        let cut = Arc::<Cut>::default();
        let of = cut.clone();
        tokio::spawn(async move {
            while let Ok((client, _)) = listener.accept().await {
                if !of.closed.load(Ordering::SeqCst) {
                    tokio::spawn(pass(client, UnixStream::connect(&socket).await.unwrap(), of.clone()));
                }
            }
        });
        Proxy { port, name, cut }
    }

    pub fn settings(&self) -> PostgresSettings {
        let url = format!("postgres://owner@127.0.0.1:{}/{}?sslmode=disable", self.port, self.name);
        let mut settings = PostgresSettings::of_url(&url).unwrap();
        (settings.writers, settings.readers) = (1, 2);
        (settings.unsafe_store, settings.patience) = (true, PATIENCE);
        settings
    }
}

/// Passes everything on until a cut falls.
async fn pass(client: TcpStream, server: UnixStream, cut: Arc<Cut>) {
    let (mut from_client, mut to_client) = client.into_split();
    let (mut from_server, mut to_server) = server.into_split();
    let up = tokio::spawn(async move { copy(&mut from_client, &mut to_server).await });
    let mut said = vec![0; 1 << 16];
    while let Ok(length @ 1..) = from_server.read(&mut said).await {
        if cut.falls(&said[..length]) || to_client.write_all(&said[..length]).await.is_err() {
            break;
        }
    }
    up.abort();
}

struct Lossy {
    proxy: Proxy,
    store: SqlStore,
    repository: Arc<dyn Repository>,
    values: Values,
}

impl Lossy {
    async fn new(patience: Duration) -> Self {
        let proxy = Proxy::new().await;
        let (ids, clock) = (Arc::new(OrderedIds::new()), Arc::new(SystemClock));
        let mut settings = proxy.settings();
        settings.patience = patience;
        let store = open_postgres(settings, ids, clock).await.unwrap();
        let repository = store.of(&caller("default"));
        Lossy { proxy, store, repository, values: Values::default() }
    }

    async fn close(self) {
        flankfit::jobs::Upkeep::close(&self.store).await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_commit_whose_answer_was_lost_is_found_and_not_repeated() {
    let lossy = Lossy::new(PATIENCE).await;
    let (store, values, cut) = (&lossy.repository, &lossy.values, &lossy.proxy.cut);
    let job = values.stored_job(store).await.id;
    for number in 1..=10 {
        cut.committed.store(true, Ordering::SeqCst);
        let keyed = Some(receipt(&number.to_string(), "POST /there"));
        assert_eq!(store.insert_iteration(values.iteration(job), keyed).await.unwrap().number, number);
        assert!(!cut.committed.load(Ordering::SeqCst), "the cut fell");
        let (_, kept) = store.answer(number.to_string(), "POST /there".to_owned()).await.unwrap().unwrap();
        assert_eq!(kept.body, format!(r#"{{"number":{number}}}"#).into_bytes());
    }
    let numbers: Vec<u32> =
        store.trace(job, WHOLE).await.unwrap().iterations.iter().map(|iteration| iteration.number).collect();
    assert!(numbers.into_iter().eq(1..=10));
    lossy.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_transaction_that_was_lost_before_is_done_again() {
    let lossy = Lossy::new(PATIENCE).await;
    let (store, values, cut) = (&lossy.repository, &lossy.values, &lossy.proxy.cut);
    let job = values.stored_job(store).await.id;
    for number in 1..=5 {
        cut.begun.store(true, Ordering::SeqCst);
        assert_eq!(store.insert_iteration(values.iteration(job), None).await.unwrap().number, number);
        // a read begins a transaction too
        cut.begun.store(true, Ordering::SeqCst);
        assert_eq!(store.trace(job, WHOLE).await.unwrap().iterations.len(), number as usize);
    }
    assert_eq!(store.last_event(job).await.unwrap(), 5);
    lossy.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn lost_commits_have_an_unknown_outcome() {
    let lossy = Lossy::new(Duration::from_secs(2)).await;
    let (store, values, cut) = (&lossy.repository, &lossy.values, &lossy.proxy.cut);
    let job = values.stored_job(store).await.id;
    cut.for_good.store(true, Ordering::SeqCst);
    cut.committed.store(true, Ordering::SeqCst);
    let lost = store.insert_iteration(values.iteration(job), None).await;
    assert!(matches!(lost, Err(RepositoryError::OutcomeUnknown(_))), "{lost:?}");
    // what has not come as far is known not to be stored
    let refused = store.insert_iteration(values.iteration(job), None).await;
    assert!(matches!(refused, Err(RepositoryError::Unavailable(_))), "{refused:?}");
    assert!(matches!(store.job(job).await, Err(RepositoryError::Unavailable(_))));
    // and the store goes on by itself
    cut.for_good.store(false, Ordering::SeqCst);
    cut.closed.store(false, Ordering::SeqCst);
    assert_eq!(store.insert_iteration(values.iteration(job), None).await.unwrap().number, 2);
    lossy.close().await;
}
