//! Processes that wake each other, by LISTEN and NOTIFY on one channel of the database.
//!
//! A notification inside of a transaction makes commits wait for each other. So a process gathers
//! its changes after its commits and sends them at most every ten milliseconds. Messages are lost
//! while a process does not listen: when it listens again, it looks everywhere.

use std::{
    collections::HashSet,
    mem,
    pin::Pin,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use sqlx::{
    PgConnection, PgPool,
    postgres::{PgListener, PgPoolOptions},
};
use tokio::{
    sync::Notify,
    time::{sleep, timeout},
};
use uuid::Uuid;

use super::{
    error::{failure, said},
    message::Message,
    open,
    settings::PostgresSettings,
};
use crate::{
    jobs::{RepositoryFuture, Wake, Wakes},
    store::sql::{Cell, Pool},
    telemetry,
};

const CHANNEL: &str = "flankfit";
/// Between two notifications.
const GATHERING: Duration = Duration::from_millis(10);
/// Between two attempts to reach a server.
const PAUSE: Duration = Duration::from_millis(200);
/// For the answer to one.
const PATIENCE: Duration = Duration::from_secs(5);
/// Wakes that may wait. More are one: anything may have happened.
const MOST: usize = 4096;

/// Messages to and from the other processes that use the database.
pub struct Notifications {
    settings: Arc<PostgresSettings>,
    readers: PgPool,
    /// Id of this process.
    id: Uuid,
    begun: Instant,
    waiting: Mutex<HashSet<Wake>>,
    some: Notify,
}

impl Notifications {
    pub fn new(settings: Arc<PostgresSettings>, readers: PgPool, id: Uuid) -> Self {
        let (waiting, some) = Default::default();
        Notifications { settings, readers, id, begun: Instant::now(), waiting, some }
    }

    fn gather(&self, wakes: impl IntoIterator<Item = Wake>) {
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.extend(wakes);
        if waiting.len() > MOST {
            *waiting = HashSet::from([Wake::Anything]);
        }
        self.some.notify_one();
    }

    /// Sends the waiting messages.
    async fn notify_others(&self) {
        let mut connection = None;
        loop {
            self.some.notified().await;
            let told = mem::take(&mut *self.waiting.lock().unwrap_or_else(PoisonError::into_inner));
            let texts = Message::write(self.id, self.begun.elapsed(), &told);
            let telling = timeout(PATIENCE, self.notify(&mut connection, &texts)).await;
            if !matches!(telling, Ok(Ok(()))) {
                connection = None;
                self.gather(told);
                sleep(PAUSE).await;
            }
            sleep(GATHERING).await;
        }
    }

    async fn notify(&self, connection: &mut Option<PgConnection>, texts: &[String]) -> Result<(), sqlx::Error> {
        let db = match connection {
            Some(db) => db,
            none => none.insert(open::connect(&self.settings).await?),
        };
        sqlx::query("SELECT pg_notify($1, text) FROM unnest($2::text[]) AS text")
            .bind(CHANNEL)
            .bind(texts)
            .execute(db)
            .await?;
        Ok(())
    }

    /// Hears the others, as often as the connection is lost.
    async fn hear_others(&self, ring: &(dyn Fn(Wake) + Send + Sync)) {
        let pool = PgPoolOptions::new()
            .max_connections(1)
            .acquire_timeout(PATIENCE)
            .connect_lazy_with(self.settings.past_a_pooler());
        loop {
            if let Err(error) = self.hear(&pool, ring).await {
                tracing::debug!(error = said(&error), "other servers are not heard");
            }
            sleep(PAUSE).await;
        }
    }

    async fn hear(&self, pool: &PgPool, ring: &(dyn Fn(Wake) + Send + Sync)) -> Result<(), sqlx::Error> {
        let mut listener = PgListener::connect_with(pool).await?;
        listener.listen(CHANNEL).await?;
        loop {
            // before this nothing was heard
            ring(Wake::Anything);
            while let Some(heard) = listener.try_recv().await? {
                match Message::read(heard.payload()) {
                    Some(own) if own.from == self.id => {
                        metrics::histogram!(telemetry::WAKE_DELAY)
                            .record(self.begun.elapsed().saturating_sub(own.sent));
                    }
                    Some(message) => message.wakes.into_iter().for_each(ring),
                    None => ring(Wake::Anything),
                }
            }
        }
    }

    async fn last(&self, jobs: Vec<Uuid>) -> Result<Vec<(Uuid, u64)>, sqlx::Error> {
        let sql = "SELECT job, coalesce((SELECT max(number) FROM events e WHERE e.job = j.job), 0)
                   FROM (SELECT DISTINCT unnest(ARRAY[{ids}]::uuid[]) AS job) AS j";
        let mut db = Pool::Postgres(self.readers.clone()).connection().await?;
        let rows: Vec<(Uuid, Cell<u64>)> = db.of_ids(sql, jobs).await?;
        Ok(rows.into_iter().map(|(job, Cell(number))| (job, number)).collect())
    }
}

impl Wakes for Notifications {
    fn send(&self, wake: Wake) {
        self.gather([wake]);
    }

    fn pass_on<'a>(&'a self, ring: &'a (dyn Fn(Wake) + Send + Sync)) -> Pin<Box<dyn Future<Output = ()> + Send + 'a>> {
        Box::pin(async move {
            tokio::join!(self.notify_others(), self.hear_others(ring));
        })
    }

    fn last_events(&self, jobs: Vec<Uuid>) -> RepositoryFuture<'_, Vec<(Uuid, u64)>> {
        Box::pin(async move { self.last(jobs).await.map_err(|error| failure(&error)) })
    }
}
