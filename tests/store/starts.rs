//! Start of stores on PostgreSQL: creation of the schema, refusals, and the rights with which they
//! work.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use flankfit::{
    jobs::{Clock, OrderedIds, Precondition, RepositoryError, Store as _, SystemClock, Unfit, Upkeep as _},
    store::{Migrate, PostgresError, PostgresSettings, SqlStore, migrate, open_postgres, postgres_migrations},
};
use futures_util::future::join_all;
use jiff::{SignedDuration, Timestamp};
use metrics_exporter_prometheus::PrometheusBuilder;
use sqlx::{AssertSqlSafe, Connection as _, Executor as _, PgConnection, migrate::Migrator};

use crate::{
    heard::Heard,
    server::Server,
    service::served,
    support::{Values, caller},
};

fn settings(url: &str) -> PostgresSettings {
    let mut settings = PostgresSettings::of_url(url).unwrap();
    (settings.writers, settings.readers, settings.unsafe_store) = (1, 1, true);
    settings.patience = Duration::from_secs(60);
    settings
}

/// The URL of a new database without a schema.
async fn empty() -> String {
    let server = Server::shared();
    server.url(&server.copy_of("template1").await)
}

async fn open(settings: PostgresSettings) -> Result<SqlStore, PostgresError> {
    open_postgres(settings, Arc::new(OrderedIds::new()), Arc::new(SystemClock)).await
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn eight_start_at_once_on_an_empty_database_or_an_old_one() {
    let all: Vec<_> = postgres_migrations().iter().cloned().collect();
    for there in 0..all.len() {
        let url = empty().await;
        let mut db = PgConnection::connect(&url).await.unwrap();
        Migrator::with_migrations(all[..there].to_vec()).run(&mut db).await.unwrap();
        for store in join_all((0..8).map(|_| open(settings(&url)))).await {
            let store = store.unwrap();
            store.ping().await.unwrap();
            store.close().await;
        }
        let made: i64 = sqlx::query_scalar("SELECT count(*) FROM _sqlx_migrations").fetch_one(&mut db).await.unwrap();
        assert_eq!(made, all.len() as i64);
    }
}

/// A server that says that it is of another version than it is.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_server_that_is_too_old_is_refused() {
    let url = empty().await;
    let mut db = PgConnection::connect(&url).await.unwrap();
    let first = "CREATE SCHEMA pretended;
        DO $$ BEGIN
            EXECUTE format('ALTER DATABASE %I SET search_path = pretended, pg_catalog, public', current_database());
        END $$;";
    db.execute(sqlx::raw_sql(first)).await.unwrap();
    let mut settings = settings(&url);
    settings.migrate = Migrate::Check;
    for (version, major) in [(130_022, Some(13)), (149_999, Some(14)), (150_000, None), (180_001, None)] {
        let says = format!(
            "CREATE OR REPLACE FUNCTION pretended.current_setting(name text) RETURNS text LANGUAGE sql AS $$
                 SELECT CASE name WHEN 'server_version_num' THEN '{version}' ELSE pg_catalog.current_setting(name) END
             $$"
        );
        db.execute(sqlx::raw_sql(AssertSqlSafe(says))).await.unwrap();
        match open(settings.clone()).await {
            Ok(store) => {
                assert_eq!(major, None, "{version}");
                store.close().await;
            }
            Err(error) => {
                assert!(matches!(error, PostgresError::TooOld { version, .. } if Some(version) == major), "{error}");
                assert!(error.to_string().ends_with("flankfit needs 15 or later"), "{error}");
            }
        }
    }
}

/// Migrations go past the pooler of the other URL, behind which there is nobody here.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn migrations_take_the_direct_way() {
    let url = empty().await;
    let nowhere = settings("postgres://owner@127.0.0.1:1/nowhere");
    assert!(matches!(migrate(&nowhere).await, Err(PostgresError::Connect { .. })));
    migrate(&nowhere.direct(&url).unwrap()).await.unwrap();
    let mut checked = settings(&url);
    checked.migrate = Migrate::Check;
    let store = open(checked).await.unwrap();
    store.ping().await.unwrap();
    store.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_store_that_makes_no_schema_is_ready_once_there_is_one() {
    let url = empty().await;
    let mut settings = settings(&url);
    settings.migrate = Migrate::Check;
    let store = open(settings.clone()).await.unwrap();
    let (repository, values) = (store.of(&caller("default")), Values::default());
    let unready = store.ping().await;
    assert!(matches!(unready, Err(RepositoryError::Unfit(Unfit::NoSchema))), "{unready:?}");
    let refused = repository.insert_job(values.job("early"), None).await;
    assert!(matches!(refused, Err(RepositoryError::Unavailable(_))), "{refused:?}");
    migrate(&settings).await.unwrap();
    store.ping().await.unwrap();
    values.stored_job(&repository).await;

    // the next version has been here, and this one works on what it has added
    let mut db = PgConnection::connect(&url).await.unwrap();
    let next = "INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time)
                VALUES (1000, 'the next version', true, '', 0)";
    db.execute(next).await.unwrap();
    store.ping().await.unwrap();
    let mut beside = settings.clone();
    beside.migrate = Migrate::Auto;
    let beside = open(beside).await.unwrap();
    values.stored_job(&beside.of(&caller("default"))).await;
    beside.close().await;

    // a schema for which this version is too old
    db.execute("UPDATE schema_floor SET migration = 1000").await.unwrap();
    let unready = store.ping().await;
    assert!(matches!(unready, Err(RepositoryError::Unfit(Unfit::NewSchema(1000)))), "{unready:?}");
    settings.migrate = Migrate::Auto;
    let refused = open(settings).await.map(drop);
    assert!(matches!(refused, Err(PostgresError::Newer { migration: 1000, .. })), "{refused:?}");
    store.close().await;
}

/// A clock that is before the right one.
struct Before(SignedDuration);

impl Clock for Before {
    fn now(&self) -> Timestamp {
        SystemClock.now() + self.0
    }
}

/// Result of a ping that took less than a second: half of a pause of the machine during one would
/// be reported as a difference of the clocks.
async fn asked_quickly(store: &SqlStore, heard: &Heard) -> Result<(), RepositoryError> {
    for _ in 0..60 {
        heard.take();
        let begun = Instant::now();
        let ping = store.ping().await;
        if begun.elapsed() < Duration::from_secs(1) {
            return ping;
        }
    }
    panic!("no ping takes less than a second");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_clock_far_from_the_databases_is_not_served_with() {
    let url = Server::shared().database().await;
    // metrics of this thread alone: other tests have other clocks
    let recorder = PrometheusBuilder::new().build_recorder();
    let handle = recorder.handle();
    let _here = metrics::set_default_local_recorder(&recorder);
    let (heard, _while_heard) = Heard::here();
    for (seconds, ready) in [(-12, false), (-8, true), (0, true), (8, true), (12, false)] {
        let clock = Arc::new(Before(SignedDuration::from_secs(seconds)));
        let store = open_postgres(settings(&url), Arc::new(OrderedIds::new()), clock).await.unwrap();
        match asked_quickly(&store, &heard).await {
            Ok(()) => assert!(ready, "{seconds} s"),
            Err(RepositoryError::Unfit(Unfit::Clock(_))) => assert!(!ready, "{seconds} s"),
            Err(other) => panic!("{other}"),
        }
        // by how much the clock of the database is before ours
        let text = handle.render();
        let skew = text.lines().find_map(|line| line.strip_prefix("flankfit_clock_skew_seconds ")?.parse::<f64>().ok());
        assert!(skew.is_some_and(|skew| (skew + seconds as f64).abs() < 1.0), "{seconds} s: {text}");
        let warned = heard.take();
        assert_eq!(
            warned.contains("WARN") && warned.contains("the clock of the database is"),
            seconds != 0,
            "{warned}"
        );
        store.close().await;
    }
}

/// The schema is complete, so all that a server of another role than its owner's lacks is a
/// setting.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_role_without_rights_on_the_schema_gets_advice() {
    let [_, url] = served().await;
    let refused = open(settings(&url)).await.map(drop).unwrap_err();
    assert!(matches!(refused, PostgresError::Migration { .. }), "{refused}");
    let message = refused.to_string();
    assert!(
        ["permission denied", "`flankfit migrate`", "--migrate check"].iter().all(|part| message.contains(part)),
        "{message}"
    );
    assert!(!message.contains(" at line "), "{message}");
}

/// PostgreSQL's codes for a missing right, and for a refusal by a trigger.
const NO_RIGHT: &str = "42501";
const RESTRICTED: &str = "23001";

/// The service as a member of `flankfit_app`: it does everything, and may not change the trace.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn the_service_has_no_right_to_change_the_trace() {
    let [_, url] = served().await;
    let mut settings = settings(&url);
    settings.migrate = Migrate::Check;
    let store = open(settings).await.unwrap();
    let (repository, values) = (store.of(&caller("default")), Values::default());
    store.ping().await.unwrap();
    store.check_writable(values.now()).await.unwrap();
    let job = values.stored_job(&repository).await.id;
    values.stored_iteration(&repository, job).await;
    values.stored_record(&repository, job).await;
    let stream = Arc::new(values.stream(job));
    repository.insert_stream(stream.clone(), None).await.unwrap();
    repository.insert_block(values.block(stream.id, 1), None).await.unwrap();
    repository.delete_stream(stream.id, Precondition::None, values.now()).await.unwrap();
    let empty = values.stored_job(&repository).await.id;
    repository.delete_job(empty, Precondition::None).await.unwrap();
    store.forget_answers(values.now(), 10).await.unwrap();
    store.forget_event_order(values.now(), values.now(), 10).await.unwrap();

    let mut service = PgConnection::connect(&url).await.unwrap();
    let trace = ["iterations", "nodes", "fits", "fit_choices", "decisions", "records", "purges"];
    let audit = ["audit", "audit_seals", "audit_chain"];
    let mut refused: Vec<(String, &str)> = Vec::new();
    for table in trace.into_iter().chain(audit) {
        let column = match table {
            "purges" => "reason",
            "audit" => "subject",
            _ => "number",
        };
        refused.push((format!("UPDATE {table} SET {column} = {column}"), NO_RIGHT));
        refused.extend(["DELETE FROM", "TRUNCATE"].map(|how| (format!("{how} {table}"), NO_RIGHT)));
    }
    // a job that has nothing takes its events along, but no other
    for (how, code) in [("UPDATE events SET kind = 'fit'", NO_RIGHT), ("DELETE FROM events", RESTRICTED)] {
        refused.push((how.to_owned(), code));
    }
    for (sql, code) in refused {
        let error = service.execute(sqlx::raw_sql(AssertSqlSafe(sql.clone()))).await.unwrap_err();
        let found = error.as_database_error().and_then(|error| error.code()).map(|code| code.into_owned());
        assert_eq!(found.as_deref(), Some(code), "{sql}: {error}");
    }
    store.close().await;
}
