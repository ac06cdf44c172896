//! Reads of several statements on PostgreSQL, between which something is stored: what they answer
//! is of the state in which they began.

use std::{
    cell::Cell,
    fmt::Debug,
    pin::pin,
    sync::Arc,
    task::{Context, Poll, Waker},
    time::Duration,
};

use flankfit::{
    jobs::{
        JobPatch, OrderedIds, Precondition, Repository, Store as _, SystemClock, Tenant, Upkeep as _,
        archive::{Key, export},
    },
    store::{PostgresSettings, SqlStore, open_postgres},
};
use sqlx::{Connection as _, Executor as _, PgConnection};
use uuid::Uuid;

use crate::{
    server::Server,
    support::{Values, WHOLE, caller},
};

/// A job of two iterations.
struct Held {
    url: String,
    repository: Arc<dyn Repository>,
    values: Values,
    job: Uuid,
}

impl Held {
    /// Stores something that is read behind the records of the first iteration, of all reads below.
    async fn change(&self) {
        let patch = JobPatch { name: Some(self.values.id().to_string()), ..JobPatch::default() };
        self.repository.patch_job(self.job, patch, Precondition::None, self.values.now()).await.unwrap();
        // the version of an iteration counts its records, which are locked: the store would wait
        let fit = "INSERT INTO fits SELECT (jsonb_populate_record(f, jsonb_build_object('id', gen_random_uuid(),
                       'position', (SELECT max(position) + 1 FROM fits WHERE job = $1 AND number = 2)))).*
                   FROM fits f WHERE job = $1 AND number = 2 AND position = 1";
        let mut own = PgConnection::connect(&self.url).await.unwrap();
        sqlx::query(fit).bind(self.job).execute(&mut own).await.unwrap();
    }

    /// Has a read wait in its middle for the table of records, which is held, while something is
    /// stored.
    async fn sees_one_state<T: PartialEq + Debug>(&self, read: impl AsyncFn() -> Result<T, String>) {
        let mut holder = PgConnection::connect(&self.url).await.unwrap();
        let mut looking = PgConnection::connect(&self.url).await.unwrap();
        let waits = "SELECT EXISTS (SELECT FROM pg_stat_activity
                                    WHERE datname = current_database() AND wait_event_type = 'Lock')";
        let mut failures = Vec::new();
        while failures.len() < 20 {
            let before = read().await.unwrap();
            holder.execute("BEGIN; LOCK TABLE records IN ACCESS EXCLUSIVE MODE").await.unwrap();
            let done = Cell::new(false);
            let reading = async {
                let found = read().await;
                done.set(true);
                found
            };
            let storing = async {
                while !done.get() && !sqlx::query_scalar::<_, bool>(waits).fetch_one(&mut looking).await.unwrap() {
                    tokio::time::sleep(Duration::from_millis(5)).await;
                }
                self.change().await;
                holder.execute("ROLLBACK").await.unwrap();
            };
            let (meanwhile, ()) = tokio::join!(reading, storing);
            match meanwhile {
                Ok(meanwhile) => {
                    assert_eq!(meanwhile, before, "it has not seen what was stored meanwhile");
                    assert_ne!(read().await.unwrap(), before, "which is there to be seen");
                    return;
                }
                // a read waits two seconds for a lock, which a busy machine may take longer to give
                Err(error) => failures.push(error),
            }
        }
        panic!("{failures:?}");
    }
}

/// A store of one writing connection and so many that read.
async fn reading(url: &str, readers: u32) -> SqlStore {
    let mut settings = PostgresSettings::of_url(url).unwrap();
    (settings.writers, settings.readers, settings.unsafe_store) = (1, readers, true);
    settings.patience = Duration::from_secs(60);
    open_postgres(settings, Arc::new(OrderedIds::new()), Arc::new(SystemClock)).await.unwrap()
}

/// A caller may leave at any moment: the next use of the connection sees the present state.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_read_that_is_given_up_leaves_no_old_state() {
    let store = reading(&Server::shared().database().await, 1).await;
    let (repository, values) = (store.of(&caller("default")), Values::default());
    let job = values.stored_job(&repository).await.id;
    values.stored_iteration(&repository, job).await;
    let (mut step, mut is_read) = (0, false);
    while !is_read {
        step += 1;
        {
            let mut given_up = pin!(repository.trace(job, WHOLE));
            for poll in 1..=step {
                if let Poll::Ready(read) = given_up.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
                    read.unwrap();
                    is_read = true;
                    break;
                }
                // given up before the server has responded, or before the response was read
                if poll < step || step % 2 == 0 {
                    tokio::time::sleep(Duration::from_millis(1)).await;
                }
            }
        }
        // by then the connection has gone back; a transaction left in it would take its state with
        // this read
        tokio::time::sleep(Duration::from_millis(20)).await;
        repository.job(job).await.unwrap();
        let name = format!("after step {step}");
        let patch = JobPatch { name: Some(name.clone()), ..JobPatch::default() };
        repository.patch_job(job, patch, Precondition::None, values.now()).await.unwrap();
        assert_eq!(repository.job(job).await.unwrap().name, name);
    }
    assert!(step > 1, "it takes several steps to read: {step}");
    store.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn reads_of_several_statements_see_one_state() {
    let url = Server::shared().database().await;
    let store = reading(&url, 2).await;
    let (repository, values) = (store.of(&caller("default")), Values::default());
    let job = values.stored_job(&repository).await.id;
    for _ in 0..2 {
        values.stored_iteration(&repository, job).await;
    }
    let held = Held { url, repository: repository.clone(), values, job };
    // fits of the second iteration, behind the records of the first
    held.sees_one_state(async || repository.trace(job, WHOLE).await.map_err(|error| error.to_string())).await;
    // rows behind the entries: of another state they would be errors
    held.sees_one_state(async || {
        let verdict = store.auditor().job(Tenant::default(), job).await.map_err(|error| error.to_string())?;
        Ok(verdict)
    })
    .await;
    // entries after the rows that they describe
    held.sees_one_state(async || {
        let (key, mut text) = (Key { tenant: Tenant::default(), job }, String::new());
        let write = |line: String| {
            text += &line;
            std::future::ready(Ok(()))
        };
        export(&*store.holdings(), &key, write).await.map_err(|error| error.to_string())?;
        Ok(text)
    })
    .await;
    store.close().await;
}
