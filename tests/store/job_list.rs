//! Jobs from before there was a list with what became of them are in it.

use std::sync::Arc;

use flankfit::{
    jobs::{
        Decision, JobFilter, JobQuery, JobStatus, ListedJob, OrderedIds, Repository, Store, SystemClock, Upkeep as _,
        folded,
    },
    store::{PostgresSettings, PostgresStore, migrations, postgres_migrations},
};
use sqlx::{AssertSqlSafe, ConnectOptions as _, Connection as _, PgConnection, migrate::Migrator};
use uuid::Uuid;

use crate::{
    server::Server,
    support::{Place, all_jobs, caller},
};

/// Times of the rows.
const TIMES: [&str; 3] = ["2026-01-02T03:04:05.000006Z", "2026-01-03T03:04:05.000006Z", "2026-01-04T03:04:05.000006Z"];

/// What the list tells of them: one that is new, one that was decided and measured again, one that
/// is accepted by its last iteration's second decision.
async fn check(store: &Arc<dyn Repository>, [new, open, accepted]: [Uuid; 3]) {
    let listed: Vec<ListedJob> = store.jobs(all_jobs()).await.unwrap().items;
    let of = |id: Uuid| listed.iter().find(|listed| listed.job.id == id).unwrap();
    let time = |k: usize| TIMES[k].parse().unwrap();
    for (id, status, count, decision, changed) in [
        (new, JobStatus::New, 0, None, 0),
        (open, JobStatus::Open, 2, None, 2),
        (accepted, JobStatus::Accepted, 1, Some(Decision::Accept), 1),
    ] {
        let told = of(id);
        let is = (told.status, told.iteration_count, told.decision, told.changed_at);
        assert_eq!(is, (status, count, decision, time(changed)), "{}", told.job.name);
        assert_eq!(told.last_measured_at.is_some(), count > 0);
    }
    let text = Some(folded("ÖSTERREICH"));
    let query = JobQuery { filter: JobFilter { text, ..JobFilter::default() }, ..all_jobs() };
    let found: Vec<Uuid> = store.jobs(query).await.unwrap().items.iter().map(|listed| listed.job.id).collect();
    assert_eq!(found, [accepted, open, new], "each is searched by its name in lower case");
}

#[tokio::test]
async fn older_jobs_of_sqlite_are_listed() {
    let place = Place::new();
    let options = sqlx::sqlite::SqliteConnectOptions::new().filename(place.file()).create_if_missing(true);
    let mut old = options.connect().await.unwrap();
    migrations().run_to(16, &mut old).await.unwrap();
    let ids = [place.id(), place.id(), place.id()];
    let blob = |id: Uuid| format!("x'{}'", id.simple());
    let [t0, t1, t2] = TIMES.map(|time| format!("'{time}'"));
    let mut sql = String::new();
    for (seq, id) in ids.iter().enumerate() {
        sql += &format!(
            "INSERT INTO jobs (seq, id, name, tags, version, created_at, updated_at)
             VALUES ({seq}, {}, 'Österreich {seq}', '{{}}', 1, {t0}, {t0});",
            blob(*id)
        );
    }
    for (seq, job, number, time) in [(1, 1, 1, &t0), (2, 1, 2, &t1), (3, 2, 1, &t0)] {
        sql += &format!(
            "INSERT INTO iterations (seq, id, job, number, created_at) VALUES ({seq}, {0}, {job}, {number}, {time});
             INSERT INTO fits (seq, id, iteration, created_at, spec, result)
             VALUES ({seq}, {0}, {seq}, {time}, '{{}}', '{{}}');
             INSERT INTO fit_choices (iteration, position, fit, created_at) VALUES ({seq}, 1, {seq}, {time});",
            blob(place.id())
        );
    }
    sql += &format!(
        "INSERT INTO decisions (iteration, position, decision, created_at)
         VALUES (1, 1, 'remachine', {t1}), (3, 1, 'reject', {t1}), (3, 2, 'accept', {t1});
         INSERT INTO records (id, iteration, kind, method, created_at, request, result)
         VALUES ({}, 1, 'curve', 'newton', {t2}, '{{}}', '{{}}')",
        blob(place.id())
    );
    sqlx::raw_sql(AssertSqlSafe(sql)).execute(&mut old).await.unwrap();
    old.close().await.unwrap();
    let store = place.open().await;
    check(&store.repository, ids).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn older_jobs_of_postgres_are_listed() {
    let server = Server::shared();
    let url = server.url(&server.copy_of("template1").await);
    let mut db = PgConnection::connect(&url).await.unwrap();
    let before: Vec<_> = postgres_migrations().iter().filter(|migration| migration.version < 7).cloned().collect();
    Migrator::with_migrations(before).run(&mut db).await.unwrap();
    let place = Place::new();
    let ids = [place.id(), place.id(), place.id()];
    let [t0, t1, t2] = TIMES.map(|time| format!("'{time}'"));
    let job = |k: usize, name: &str| {
        format!(
            "INSERT INTO jobs (id, tenant, name, tags, version, created_at, updated_at)
             VALUES ('{}', 'default', '{name} {k}', '{{}}', 1, {t0}, {t0});",
            ids[k]
        )
    };
    let mut sql: String = (0..3).map(|k| job(k, "Österreich")).collect();
    for (job, number, time) in [(1, 1, &t0), (1, 2, &t1), (2, 1, &t0)] {
        let (job, id) = (ids[job], place.id());
        sql += &format!(
            "INSERT INTO iterations (job, number, id, created_at) VALUES ('{job}', {number}, '{id}', {time});
             INSERT INTO fits (job, number, position, id, created_at, spec, result)
             VALUES ('{job}', {number}, 1, '{id}', {time}, '{{}}', '{{}}');
             INSERT INTO fit_choices (job, number, position, fit, created_at) VALUES ('{job}', {number}, 1, 1, {time});"
        );
    }
    let (open, accepted, record) = (ids[1], ids[2], place.id());
    sql += &format!(
        "INSERT INTO decisions (job, number, position, decision, created_at)
         VALUES ('{open}', 1, 1, 'remachine', {t1}), ('{accepted}', 1, 1, 'reject', {t1}),
                ('{accepted}', 1, 2, 'accept', {t1});
         INSERT INTO records (job, number, position, id, kind, method, created_at, request, result)
         VALUES ('{open}', 1, 1, '{record}', 'curve', 'newton', {t2}, '{{}}', '{{}}')"
    );
    sqlx::raw_sql(AssertSqlSafe(sql)).execute(&mut db).await.unwrap();
    let mut settings = PostgresSettings::of_url(&url).unwrap();
    (settings.writers, settings.readers, settings.unsafe_store) = (1, 1, true);
    let store = PostgresStore::open(settings, Arc::new(OrderedIds::new()), Arc::new(SystemClock)).await.unwrap();
    let repository = store.of(&caller("default"));
    check(&repository, ids).await;
    // a process of the version before writes jobs, and changes what is searched
    sqlx::raw_sql(AssertSqlSafe(format!(
        "INSERT INTO jobs (id, tenant, name, tags, version, created_at, updated_at)
         VALUES ('{}', 'default', 'From Before', '{{}}', 1, {t0}, {t0});
         UPDATE jobs SET name = 'Ungarn', version = 2, updated_at = {t1} WHERE id = '{}'",
        place.id(),
        ids[0]
    )))
    .execute(&mut db)
    .await
    .unwrap();
    for (text, count) in [("from before", 1), ("ungarn", 1), ("österreich", 2)] {
        let filter = JobFilter { text: Some(text.to_owned()), ..JobFilter::default() };
        let found = repository.jobs(JobQuery { filter, ..all_jobs() }).await.unwrap().items;
        assert_eq!(found.len(), count, "{text}");
    }
    store.close().await;
}
