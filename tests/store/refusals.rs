//! PostgreSQL servers that are refused, and requests that are repeated after a refusal by the
//! server.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use flankfit::{
    jobs::{OrderedIds, Repository, RepositoryError, Store as _, SystemClock, Upkeep as _},
    store::{PostgresError, PostgresSettings, SqlStore, open_postgres},
};
use sqlx::{AssertSqlSafe, Connection as _, Executor as _, PgConnection};
use uuid::Uuid;

use crate::{
    server::{Server, shell},
    support::{Values, WHOLE, caller},
};

fn settings(url: &str) -> PostgresSettings {
    let mut settings = PostgresSettings::of_url(url).unwrap();
    (settings.writers, settings.readers, settings.patience) = (1, 2, Duration::from_secs(60));
    settings
}

async fn open(settings: PostgresSettings) -> Result<SqlStore, PostgresError> {
    open_postgres(settings, Arc::new(OrderedIds::new()), Arc::new(SystemClock)).await
}

async fn run(server: &Server, script: &'static str) {
    let mut command = shell(&server.folder, script);
    assert!(tokio::task::spawn_blocking(move || command.status()).await.unwrap().unwrap().success());
}

async fn say(url: &str, sql: &str) {
    let mut own = PgConnection::connect(url).await.unwrap();
    own.execute(sqlx::raw_sql(AssertSqlSafe(sql.to_owned()))).await.unwrap();
    own.close().await.unwrap();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn servers_with_unsafe_settings_are_refused() {
    let server = Server::start();
    let name = server.with_schema().await;
    let url = server.url(&name);
    let refused = async |expected: &str| {
        let refused = open(settings(&url)).await.map(drop);
        assert!(matches!(&refused, Err(PostgresError::Unsafe { setting, .. }) if *setting == expected), "{refused:?}");
        let mut taken = settings(&url);
        taken.unsafe_store = true;
        open(taken).await.unwrap().close().await;
    };
    refused("fsync").await;
    for (change, setting) in [
        ("ALTER SYSTEM SET fsync = on", ""),
        ("ALTER SYSTEM SET full_page_writes = off", "full_page_writes"),
        ("ALTER SYSTEM RESET full_page_writes", ""),
        ("ALTER SYSTEM SET synchronous_commit = off", "synchronous_commit"),
        ("ALTER SYSTEM SET synchronous_commit = local", ""),
    ] {
        say(&url, change).await;
        run(&server, "$BIN/pg_ctl -D data -l log -w restart").await;
        match setting {
            "" => open(settings(&url)).await.unwrap().close().await,
            setting => refused(setting).await,
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_standby_is_not_used_until_it_is_the_primary() {
    let server = Server::start();
    let mut settings = settings(&server.database().await);
    (settings.unsafe_store, settings.patience) = (true, Duration::from_secs(1));
    let store = open(settings.clone()).await.unwrap();
    let (repository, values) = (store.of(&caller("default")), Values::default());
    let job = values.stored_job(&repository).await.id;
    run(&server, "touch data/standby.signal && $BIN/pg_ctl -D data -l log -w restart").await;
    let refused = open(settings).await.map(drop);
    assert!(matches!(refused, Err(PostgresError::InRecovery { .. })), "{refused:?}");
    let refused = repository.insert_iteration(values.iteration(job), None).await;
    assert!(matches!(refused, Err(RepositoryError::Unavailable(_))), "{refused:?}");
    assert!(matches!(repository.job(job).await, Err(RepositoryError::Unavailable(_))));
    assert!(matches!(store.ping().await, Err(RepositoryError::Unavailable(_))));
    run(&server, "$BIN/pg_ctl -D data -w promote").await;
    let stored = soon(async || repository.insert_iteration(values.iteration(job), None).await).await;
    assert_eq!(stored.number, 1);
    soon(async || store.ping().await).await;
    store.close().await;
}

/// Result of a store that waits for a second only, repeated until the machine is fast enough.
async fn soon<T>(ask: impl AsyncFn() -> Result<T, RepositoryError>) -> T {
    let begun = Instant::now();
    loop {
        match ask().await {
            Err(RepositoryError::Unavailable(why)) => assert!(begun.elapsed() < Duration::from_secs(60), "{why}"),
            outcome => return outcome.unwrap(),
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

/// A store with a job, and a database in which something can be put in its way.
struct Hindered {
    url: String,
    store: SqlStore,
    repository: Arc<dyn Repository>,
    values: Values,
    job: Uuid,
}

impl Hindered {
    /// With a trigger that does this for each new iteration.
    async fn by(body: &str) -> Self {
        let url = Server::shared().database().await;
        let mut settings = settings(&url);
        settings.unsafe_store = true;
        let store = open(settings).await.unwrap();
        let (repository, values) = (store.of(&caller("default")), Values::default());
        let job = values.stored_job(&repository).await.id;
        let hinder = format!(
            "CREATE SEQUENCE attempts; CREATE TABLE said (what text, value text);
             CREATE FUNCTION hinder() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN {body} RETURN NEW; END $$;
             CREATE TRIGGER hinder BEFORE INSERT ON iterations FOR EACH ROW EXECUTE FUNCTION hinder();"
        );
        say(&url, &hinder).await;
        Hindered { url, store, repository, values, job }
    }

    async fn insert(&self) -> Result<u32, RepositoryError> {
        let stored = self.repository.insert_iteration(self.values.iteration(self.job), None).await;
        stored.map(|stored| stored.number)
    }

    async fn there(&self) -> usize {
        self.repository.trace(self.job, WHOLE).await.unwrap().iterations.len()
    }

    async fn attempts(&self) -> i64 {
        let mut own = PgConnection::connect(&self.url).await.unwrap();
        sqlx::query_scalar("SELECT last_value FROM attempts").fetch_one(&mut own).await.unwrap()
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn serialization_failures_are_retried_three_times() {
    for code in ["40001", "40P01", "55P03"] {
        let body = format!(
            "IF nextval('attempts') % 10 <> 4 THEN RAISE EXCEPTION 'in the way' USING ERRCODE = '{code}'; END IF;"
        );
        let hindered = Hindered::by(&body).await;
        assert_eq!(hindered.insert().await.unwrap(), 1, "{code}");
        assert_eq!(hindered.attempts().await, 4, "{code}");
        // attempts 5 to 8 all fail
        let refused = hindered.insert().await;
        assert!(matches!(refused, Err(RepositoryError::Unavailable(_))), "{code}: {refused:?}");
        assert_eq!((hindered.attempts().await, hindered.there().await), (8, 1), "{code}");
        hindered.store.close().await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn other_failures_are_not_retried() {
    for (code, unavailable) in [("22003", false), ("23514", false), ("53100", true), ("57014", true), ("XX000", false)]
    {
        let body = format!("PERFORM nextval('attempts'); RAISE EXCEPTION 'no' USING ERRCODE = '{code}';");
        let hindered = Hindered::by(&body).await;
        let refused = hindered.insert().await.unwrap_err();
        let is_unavailable = matches!(refused, RepositoryError::Unavailable(_));
        assert!(
            is_unavailable == unavailable && (is_unavailable || matches!(refused, RepositoryError::Failed(_))),
            "{code}: {refused:?}"
        );
        assert_eq!((hindered.attempts().await, hindered.there().await), (1, 0), "{code}");
        hindered.store.close().await;
    }
}

/// Nobody waits for a lock, a statement or a client for ever.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn sessions_wait_for_a_while_only() {
    const LIMITS: [(&str, &str); 4] = [
        ("client_connection_check_interval", "1s"),
        ("idle_in_transaction_session_timeout", "10s"),
        ("lock_timeout", "2s"),
        ("statement_timeout", "30s"),
    ];
    let body =
        LIMITS.map(|(what, _)| format!("INSERT INTO said VALUES ('{what}', current_setting('{what}'));")).concat();
    let hindered = Hindered::by(&body).await;
    hindered.insert().await.unwrap();
    let mut own = PgConnection::connect(&hindered.url).await.unwrap();
    let said: Vec<(String, String)> =
        sqlx::query_as("SELECT what, value FROM said ORDER BY what").fetch_all(&mut own).await.unwrap();
    assert!(said.iter().map(|(what, value)| (what.as_str(), value.as_str())).eq(LIMITS), "{said:?}");

    // another one holds the job
    own.execute("BEGIN; SELECT FROM jobs FOR UPDATE").await.unwrap();
    let begun = Instant::now();
    let refused = hindered.insert().await;
    assert!(matches!(refused, Err(RepositoryError::Unavailable(_))), "{refused:?}");
    let waited = begun.elapsed();
    // more only by what the machine has others do meanwhile
    assert!((8..40).contains(&waited.as_secs()), "four times two seconds: {waited:?}");
    assert_eq!(hindered.there().await, 1);
    own.execute("ROLLBACK").await.unwrap();
    assert_eq!(hindered.insert().await.unwrap(), 2);
    hindered.store.close().await;
}
