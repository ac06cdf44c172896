//! PostgreSQL restarted under writers, and connections cut under them: nothing acknowledged is
//! lost, nothing is stored twice, no number is left out, and whoever writes sees no error.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU32, Ordering},
    },
    time::{Duration, Instant},
};

use flankfit::{
    jobs::{OrderedIds, Repository, Store as _, SystemClock, Upkeep as _},
    store::{PostgresSettings, SqlStore, open_postgres},
};
use tokio::{task::JoinHandle, time::sleep};
use uuid::Uuid;

use crate::{
    cut_connections::Proxy,
    server::{Server, shell},
    support::{Values, WHOLE, caller, receipt},
};

const JOBS: usize = 4;
const WRITERS: usize = 16;
const INTERRUPTIONS: usize = 4;

/// A key that was used, and the number of the iteration under it.
type Acknowledged = (String, u32);

/// Writers that continue until they are stopped, each with one request at a time.
pub struct Writers {
    store: Arc<SqlStore>,
    repository: Arc<dyn Repository>,
    jobs: Vec<Uuid>,
    /// Acknowledged writes in each job.
    stored: Vec<Arc<AtomicU32>>,
    stop: Arc<AtomicBool>,
    /// Each with its job.
    writing: Vec<(usize, JoinHandle<Vec<Acknowledged>>)>,
    reading: Vec<JoinHandle<()>>,
}

impl Writers {
    pub async fn start(mut settings: PostgresSettings) -> Self {
        (settings.writers, settings.readers) = (2, 4);
        (settings.unsafe_store, settings.patience) = (true, Duration::from_secs(60));
        let (ids, clock) = (Arc::new(OrderedIds::new()), Arc::new(SystemClock));
        let store = Arc::new(open_postgres(settings, ids, clock).await.unwrap());
        let (repository, values) = (store.of(&caller("default")), Arc::new(Values::default()));
        let mut jobs = Vec::new();
        for _ in 0..JOBS {
            jobs.push(values.stored_job(&repository).await.id);
        }
        let stored: Vec<Arc<AtomicU32>> = jobs.iter().map(|_| Arc::default()).collect();
        let stop = Arc::<AtomicBool>::default();
        let begin = |writer: usize| {
            let (of, repository, values) = (writer % JOBS, repository.clone(), values.clone());
            let (job, stored, stop) = (jobs[of], stored[of].clone(), stop.clone());
            let write = async move {
                let mut keys = Vec::new();
                while !stop.load(Ordering::SeqCst) {
                    let key = format!("{writer}-{}", keys.len());
                    let keyed = Some(receipt(&key, "POST /there"));
                    let iteration = repository.insert_iteration(values.iteration(job), keyed).await.unwrap();
                    stored.fetch_add(1, Ordering::SeqCst);
                    keys.push((key, iteration.number));
                }
                keys
            };
            (of, tokio::spawn(write))
        };
        let writing = (0..WRITERS).map(begin).collect();
        let read = |(&job, stored): (&Uuid, &Arc<AtomicU32>)| {
            let (repository, stored, stop) = (repository.clone(), stored.clone(), stop.clone());
            tokio::spawn(async move {
                while !stop.load(Ordering::SeqCst) {
                    let acknowledged = u64::from(stored.load(Ordering::SeqCst));
                    let seen = repository.last_event(job).await.unwrap();
                    assert!(seen >= acknowledged, "{acknowledged} were acknowledged, and {seen} are there");
                    sleep(Duration::from_millis(5)).await;
                }
            })
        };
        let reading = jobs.iter().zip(&stored).map(read).collect();
        Writers { store, repository, jobs, stored, stop, writing, reading }
    }

    /// Returns when every job got something more.
    pub async fn go_on(&self) {
        let before: Vec<u32> = self.stored.iter().map(|stored| stored.load(Ordering::SeqCst)).collect();
        let since = Instant::now();
        while self.stored.iter().zip(&before).any(|(stored, before)| stored.load(Ordering::SeqCst) < before + 5) {
            assert!(since.elapsed() < Duration::from_secs(90), "nothing is stored any more");
            sleep(Duration::from_millis(5)).await;
        }
    }

    /// Ends the writers and compares the acknowledged writes with the stored ones.
    pub async fn check(self) {
        self.stop.store(true, Ordering::SeqCst);
        for reading in self.reading {
            reading.await.unwrap();
        }
        let mut numbers: Vec<Vec<u32>> = vec![Vec::new(); JOBS];
        for (of, writing) in self.writing {
            for (key, number) in writing.await.unwrap() {
                let (_, kept) = self.repository.answer(key, "POST /there".to_owned()).await.unwrap().unwrap();
                assert_eq!(kept.body, format!(r#"{{"number":{number}}}"#).into_bytes());
                numbers[of].push(number);
            }
        }
        for (&job, mut of_job) in self.jobs.iter().zip(numbers) {
            of_job.sort_unstable();
            let last = of_job.len() as u32;
            assert!(of_job.into_iter().eq(1..=last), "each number was acknowledged once");
            assert_eq!(self.repository.last_event(job).await.unwrap(), u64::from(last));
            let mut page = WHOLE;
            let mut there = Vec::new();
            loop {
                let trace = self.repository.trace(job, page).await.unwrap();
                there.extend(trace.iterations.iter().map(|iteration| iteration.number));
                page.after = trace.next;
                if page.after.is_none() {
                    break;
                }
            }
            assert!(there.into_iter().eq(1..=last), "and is there once");
        }
        self.store.close().await;
    }
}

/// Does something to a server of its own again and again.
async fn interrupted(script: &'static str) {
    let server = Server::start();
    let settings = PostgresSettings::of_url(&server.database().await).unwrap();
    let writers = Writers::start(settings).await;
    for _ in 0..INTERRUPTIONS {
        writers.go_on().await;
        let mut command = shell(&server.folder, script);
        let done = tokio::task::spawn_blocking(move || command.status()).await.unwrap().unwrap();
        assert!(done.success());
    }
    writers.go_on().await;
    writers.check().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_restart_is_a_longer_answer() {
    interrupted("$BIN/pg_ctl -D data -l log -m fast -w restart").await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_restart_without_a_checkpoint_loses_nothing() {
    interrupted("$BIN/pg_ctl -D data -l log -m immediate -w restart").await;
}

/// The next one starts when the children of the first have seen that they are alone.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_server_that_is_killed_loses_nothing() {
    interrupted(
        "kill -9 $(head -1 data/postmaster.pid); until $BIN/pg_ctl -D data -l log -w start 2>/dev/null; do sleep 0.1; done",
    )
    .await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn commits_with_lost_responses_are_stored_exactly_once() {
    let proxy = Proxy::new().await;
    let writers = Writers::start(proxy.settings()).await;
    for _ in 0..10 * INTERRUPTIONS {
        writers.go_on().await;
        proxy.cut.committed.store(true, Ordering::SeqCst);
    }
    writers.go_on().await;
    assert!(!proxy.cut.committed.load(Ordering::SeqCst), "the cuts fell");
    writers.check().await;
}
