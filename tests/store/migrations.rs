//! Migrations are only ever added, and an older database is brought up to date with what it holds.

use flankfit::{
    jobs::{Measurand, RecordKind, RepositoryError, Resource, Successors},
    store::{OpenError, SqliteStore, StoreSettings, migrations},
};
use sqlx::{ConnectOptions, SqliteConnection, sqlite::SqliteConnectOptions};
use uuid::Uuid;

use crate::support::{Place, WHOLE, all_jobs, caller, ids, receipt, still};

/// The digests of the migrations as they were released. A changed one would leave databases behind
/// that no version knows: add a migration instead, and its digest here.
const RELEASED: &[(i64, &str)] = &[
    (1, "c99dab07199656110b86660475cd2a4c"),
    (2, "7fdd19148856f83197bd5bf17768ca10"),
    (3, "31e052e1b6aee6298d19fb06e72c4de5"),
    (4, "83c8825463adfe444dc32bf19310c8be"),
    (5, "e975cea658e1b38e68d8d0127aec2066"),
    (6, "cc6dd44b14efd171f405d92408b60853"),
    (7, "c999530a59e8244e36cabdf414b202a5"),
    (8, "a62ee7e7e83f58a9b79d45b5df032fbf"),
    (9, "4f8faf8859177de0c69d524013a19f1a"),
    (10, "617996c25b4a66fdb51262767b542099"),
    (11, "32d92b45e9d2837cb2e303071e20ce78"),
    (12, "d754e3ab5a82d11c5d71424d831ceb47"),
    (13, "ce4aa2e66021ccef44f17579fe41b3f3"),
    (14, "7eed85c8183e415a9d0ae653a3635926"),
    (15, "b1bce72581b590bc6d55e35e08819e3b"),
    (16, "14a014fb760339d5ab065f859cf87ab1"),
    (17, "dc6c866c53a518a59765dd7ebac0d221"),
    (18, "6cbe316fb4f2a16aadecfdfef211475d"),
    (19, "eddfb5a15eb76e8057dc64692525cb15"),
    (20, "a091a09a8fcbe53a214b9e9a9772117e"),
    (21, "de5f82c269483001d8a133026bc85e15"),
    (22, "13681a59398690e2ea8d841d69b243b0"),
    (23, "cb20f658e816bfdb7034b9058964c54e"),
    (24, "bcf13c03f7e620ce0e2f5dd69b6f8f9d"),
    (25, "8441d81c99ab36f9c0ccc4b9cdc4eeba"),
    (26, "b2d327fbd93f2efdddae6ec135769fa8"),
    (27, "2bae9d513e0938acb341efa27a194b1e"),
    (28, "5da634d2390d0b119471f89b70e283d1"),
    (29, "1c7e41659d5c1ef960151a6cb41d6f6f"),
    (30, "f01ac38af9a76da1700e8728017af159"),
    (31, "4c72886ed8f90aba078b7fcf72c89683"),
    (32, "89da9887fabb2c5e7439fdf0cfcf49de"),
    (33, "a387a4803ba38d7dfeb94fefc1eb69e0"),
    (34, "c7e547c863a999bc112cbe53eeef867e"),
];

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn released_migrations_are_unchanged() {
    let known: Vec<(i64, String)> =
        migrations().iter().map(|migration| (migration.version, hex(&migration.checksum[..16]))).collect();
    let released: Vec<(i64, String)> =
        RELEASED.iter().map(|(version, digest)| (*version, (*digest).to_owned())).collect();
    assert_eq!(known, released);
}

#[tokio::test]
async fn an_older_database_is_brought_up_to_date() {
    let place = Place::new();
    let mut old = SqliteConnectOptions::new().filename(place.file()).create_if_missing(true).connect().await.unwrap();
    migrations().run_to(1, &mut old).await.unwrap();
    let job = place.job("from before");
    sqlx::query(
        "INSERT INTO jobs (id, name, tags, version, created_at, updated_at)
         VALUES (?, 'from before', '{}', 3, '2026-01-02T03:04:05.000006Z', '2026-01-02T03:04:05.000006Z')",
    )
    .bind(job.id)
    .execute(&mut old)
    .await
    .unwrap();
    sqlx::Connection::close(old).await.unwrap();

    let store = place.open().await;
    let back = store.job(job.id).await.unwrap();
    assert_eq!((back.name.as_str(), back.version), ("from before", 3));
    let (_, stored) = place.stored_iteration(&store, job.id).await;
    assert_eq!(stored.number, 1);
}

/// An iteration of a job as a database of old has it, with its time.
async fn older_iteration(db: &mut SqliteConnection, job: Uuid, fit: Uuid) -> &'static str {
    let at = "2026-01-02T03:04:05.000006Z";
    for (sql, id) in [
        (
            "INSERT INTO jobs (seq, id, name, tags, version, created_at, updated_at)
             VALUES (1, ?1, 'w', '{}', 1, ?2, ?2)",
            job,
        ),
        ("INSERT INTO iterations (seq, id, job, number, created_at) VALUES (1, ?1, 1, 1, ?2)", fit),
        (
            "INSERT INTO fits (seq, id, iteration, created_at, spec, result) VALUES (1, ?1, 1, ?2, '{}', \
             '{\"coefficients\":[]}')",
            fit,
        ),
        ("INSERT INTO fit_choices (iteration, position, fit, created_at) VALUES (1, 1, 1, ?2)", fit),
        ("INSERT INTO nodes (iteration, count, data) VALUES (1, 0, x'00')", fit),
    ] {
        sqlx::query(sql).bind(id).bind(at).execute(&mut *db).await.unwrap();
    }
    at
}

#[tokio::test]
async fn shapes_become_records() {
    let place = Place::new();
    let mut old = SqliteConnectOptions::new().filename(place.file()).create_if_missing(true).connect().await.unwrap();
    migrations().run_to(7, &mut old).await.unwrap();
    let (job, shape) = (place.job("from before"), place.record(RecordKind::Surface, "gregory"));
    let at = older_iteration(&mut old, job.id, place.id()).await;
    sqlx::query(
        "INSERT INTO shapes (id, iteration, kind, method, created_at, request, result)
         VALUES (?, 1, 'surface', 'gregory', ?, ?, ?)",
    )
    .bind(shape.id)
    .bind(at)
    .bind(&*shape.draft.request)
    .bind(&*shape.draft.result)
    .execute(&mut old)
    .await
    .unwrap();
    sqlx::Connection::close(old).await.unwrap();

    let store = place.open().await;
    let back = store.record(job.id, 1, shape.id).await.unwrap();
    assert_eq!(back.draft, shape.draft);
    assert_eq!(store.latest_record(job.id, 1, RecordKind::Surface).await.unwrap(), Some(back));
    assert_eq!(store.latest_record(job.id, 1, RecordKind::Curve).await.unwrap(), None);
    let told = store.trace(job.id, WHOLE).await.unwrap();
    assert_eq!(told.iterations[0].records.iter().map(|record| record.id).collect::<Vec<_>>(), [shape.id]);
}

/// Iterations from before have no measurand, and what is written from now on has one.
#[tokio::test]
async fn older_iterations_tell_no_flank() {
    let place = Place::new();
    let mut old = SqliteConnectOptions::new().filename(place.file()).create_if_missing(true).connect().await.unwrap();
    migrations().run_to(8, &mut old).await.unwrap();
    let job = place.job("from before");
    older_iteration(&mut old, job.id, place.id()).await;
    sqlx::Connection::close(old).await.unwrap();

    let store = place.open().await;
    assert_eq!(store.measurand(job.id, 1).await.unwrap(), Measurand::default());
    assert_eq!(store.iteration(job.id, 1).await.unwrap().measurand, Measurand::default());
    let (new, stored) = place.stored_iteration(&store, job.id).await;
    assert_eq!(store.measurand(job.id, stored.number).await.unwrap(), new.measurand);
    // what one of two tells and the other does not is not the same
    assert_eq!(store.successors(job.id, 1).await.unwrap(), Successors { alike: None, any: Some(2) });
    place.stored_iteration(&store, job.id).await;
    assert_eq!(store.successors(job.id, 2).await.unwrap(), Successors { alike: Some(3), any: Some(3) });
    assert_eq!(store.successors(job.id, 3).await.unwrap(), Successors::default());
}

/// Jobs from before there were tenants are `default`'s, and so are the answers kept.
#[tokio::test]
async fn older_jobs_and_answers_belong_to_the_default_tenant() {
    let place = Place::new();
    let mut old = SqliteConnectOptions::new().filename(place.file()).create_if_missing(true).connect().await.unwrap();
    migrations().run_to(10, &mut old).await.unwrap();
    let (job, fit, stream) = (place.id(), place.fit(0.5), place.id());
    let at = "2026-11-21T03:04:05.000006Z";
    for (sql, id) in [
        (
            "INSERT INTO jobs (seq, id, name, tags, version, created_at, updated_at)
             VALUES (1, ?1, 'w', '{}', 1, ?2, ?2)",
            job,
        ),
        ("INSERT INTO iterations (seq, id, job, number, created_at) VALUES (1, ?1, 1, 1, ?2)", fit.id),
        ("INSERT INTO fits (seq, id, iteration, created_at, spec, result) VALUES (1, ?1, 1, ?2, '{}', '{}')", fit.id),
        ("INSERT INTO fit_choices (iteration, position, fit, created_at) VALUES (1, 1, 1, ?2)", fit.id),
        ("INSERT INTO nodes (iteration, count, data) VALUES (1, 0, x'00')", fit.id),
        (
            "INSERT INTO streams (id, job, spec, forgetting_factor, sequence, node_count, input_sha256, version,
                                  created_at, updated_at)
             VALUES (?1, 1, '{}', 1.0, 0, 0, zeroblob(32), 1, ?2, ?2)",
            stream,
        ),
        (
            "INSERT INTO idempotency_keys (key, scope, request_sha256, status, location, etag, body, created_at)
             VALUES ('k', 'POST /v1/jobs', zeroblob(32), 201, '/v1/jobs/' || hex(?1), '\"1\"', x'7b7d', ?2),
                    ('k', 'POST /elsewhere', zeroblob(32), 200, NULL, NULL, x'', ?2)",
            job,
        ),
    ] {
        sqlx::query(sql).bind(id).bind(at).execute(&mut old).await.unwrap();
    }
    sqlx::Connection::close(old).await.unwrap();

    let store = place.open().await;
    assert_eq!(store.jobs(all_jobs()).await.unwrap().items.len(), 1);
    assert_eq!(store.iteration(job, 1).await.unwrap().fits[0].id, fit.id);
    assert_eq!(store.stream(stream).await.unwrap().job_id, job);
    assert_eq!(store.last_event(job).await.unwrap(), 2);
    let (digest, answer) = store.answer("k".into(), "POST /v1/jobs".into()).await.unwrap().unwrap();
    assert_eq!((digest, answer.status, answer.etag.as_deref()), ([0; 32], 201, Some("\"1\"")));
    assert_eq!(answer.location, Some(format!("/v1/jobs/{}", job.simple().to_string().to_uppercase())));
    assert_eq!(answer.body, b"{}");
    let empty = store.answer("k".into(), "POST /elsewhere".into()).await.unwrap().unwrap().1;
    assert_eq!((empty.status, empty.location, empty.etag, empty.body), (200, None, None, Vec::new()));
    let taken = store.insert_job(place.job("again"), Some(receipt("k", "POST /v1/jobs"))).await;
    assert!(matches!(taken, Err(RepositoryError::KeyTaken)));

    let other = store.store.of(&caller("other"));
    assert_eq!(other.jobs(all_jobs()).await.unwrap().items, []);
    assert!(matches!(other.stream(stream).await, Err(RepositoryError::NotFound(Resource::Stream))));
    assert_eq!(other.answer("k".into(), "POST /v1/jobs".into()).await.unwrap(), None);
    other.insert_job(place.job("theirs"), Some(receipt("k", "POST /v1/jobs"))).await.unwrap();
    assert_eq!(store.jobs(all_jobs()).await.unwrap().items.len(), 1);
}

/// The list of kinds is changed in the text of the table alone: what refers to it, what is refused
/// and what is stored stay.
#[tokio::test]
async fn older_records_stay_beside_pitches() {
    let place = Place::new();
    let mut old = SqliteConnectOptions::new().filename(place.file()).create_if_missing(true).connect().await.unwrap();
    migrations().run_to(19, &mut old).await.unwrap();
    let about = "SELECT type, name, CASE name WHEN 'records' THEN '' ELSE sql END
                 FROM sqlite_schema WHERE tbl_name = 'records' ORDER BY name";
    let before: Vec<(String, String, Option<String>)> = sqlx::query_as(about).fetch_all(&mut old).await.unwrap();
    let (at, id) = ("2026-11-21T03:04:05.000006Z", place.id());
    for sql in [
        "INSERT INTO jobs (seq, id, name, tags, version, created_at, updated_at)
         VALUES (1, ?1, 'w', '{}', 1, ?2, ?2)",
        "INSERT INTO iterations (seq, id, job, number, created_at) VALUES (1, ?1, 1, 1, ?2)",
        "INSERT INTO records (seq, id, iteration, kind, method, created_at, request, result)
         VALUES (1, ?1, 1, 'evaluation', 'iso_1328_1', ?2, '{}', '{\"class\": 7}')",
        // as a purge leaves it
        "INSERT INTO records (seq, id, iteration, kind, method, created_at, request, result)
         VALUES (2, zeroblob(16), 1, 'evaluation', 'iso_1328_1', ?2, '', '')",
    ] {
        sqlx::query(sql).bind(id).bind(at).execute(&mut old).await.unwrap();
    }
    migrations().run_to(20, &mut old).await.unwrap();
    sqlx::Connection::close(old).await.unwrap();
    let mut own = place.connect().await;
    let after: Vec<(String, String, Option<String>)> = sqlx::query_as(about).fetch_all(&mut own).await.unwrap();
    assert_eq!(before, after);
    sqlx::Connection::close(own).await.unwrap();

    place.open().await.close().await;
    let mut own = place.connect().await;
    let kinds: Vec<String> = sqlx::query_scalar("SELECT kind FROM records").fetch_all(&mut own).await.unwrap();
    assert_eq!(kinds, ["evaluation"; 2]);
    let classes: Vec<Option<i64>> =
        sqlx::query_scalar("SELECT class FROM records ORDER BY seq").fetch_all(&mut own).await.unwrap();
    assert_eq!(classes, [Some(7), None]);
    let insert = |kind: &str| {
        format!(
            "INSERT INTO records (id, iteration, kind, method, created_at, request, result)
             VALUES (randomblob(16), 1, '{kind}', 'm', '{at}', '{{}}', '{{}}')"
        )
    };
    for kind in ["pitch", "correction", "gear_correction", "applied"] {
        sqlx::raw_sql(sqlx::AssertSqlSafe(insert(kind))).execute(&mut own).await.unwrap();
    }
    for kind in ["pitches", "", "Pitch"] {
        let refused = sqlx::raw_sql(sqlx::AssertSqlSafe(insert(kind))).execute(&mut own).await.unwrap_err();
        assert!(refused.to_string().contains("CHECK constraint failed"), "{refused}");
    }
    let sound: String = sqlx::query_scalar("PRAGMA integrity_check").fetch_one(&mut own).await.unwrap();
    assert_eq!(sound, "ok");
}

#[tokio::test]
async fn a_newer_database_is_refused_in_words() {
    let place = Place::new();
    place.open().await.close().await;
    let mut own = place.connect().await;
    sqlx::query(
        "INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time)
         VALUES (9999, 'from the future', 1, x'00', 0)",
    )
    .execute(&mut own)
    .await
    .unwrap();
    let refused = SqliteStore::open(StoreSettings::of_file(place.file()), ids(), still(place.now())).await.err();
    assert!(matches!(refused, Some(OpenError::Newer { version: 9999, .. })), "{refused:?}");
}

#[tokio::test]
async fn what_cannot_be_opened_is_explained() {
    let place = Place::new();
    let open = async |settings: StoreSettings| match SqliteStore::open(settings, ids(), still(place.now())).await {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    let nowhere = open(StoreSettings::of_file(place.beside("no/such/directory/jobs.db"))).await;
    assert!(nowhere.contains("its directory must exist and be writable"), "{nowhere}");
    std::fs::write(place.file(), "not a database, but long enough to have a header of a hundred bytes ".repeat(20))
        .unwrap();
    let foreign = open(StoreSettings::of_file(place.file())).await;
    assert!(foreign.contains("is not an SQLite database"), "{foreign}");
    assert!(matches!(StoreSettings::of_url("sqlite::memory:"), Err(OpenError::InMemory)));
    assert!(matches!(StoreSettings::of_url("postgres://host/db"), Err(OpenError::Url { .. })));
}

/// Events from before stay as they are, and a purge can be told among them.
#[tokio::test]
async fn older_events_are_joined_by_that_of_a_purge() {
    let place = Place::new();
    let mut old = SqliteConnectOptions::new().filename(place.file()).create_if_missing(true).connect().await.unwrap();
    migrations().run_to(23, &mut old).await.unwrap();
    let job = place.job("from before");
    let at = "2026-01-02T03:04:05.000006Z";
    let insert =
        "INSERT INTO jobs (seq, id, name, tags, version, created_at, updated_at) VALUES (1, ?, 'w', '{}', 1, ?, ?)";
    sqlx::query(insert).bind(job.id).bind(at).bind(at).execute(&mut old).await.unwrap();
    let event = "INSERT INTO events (job, number, kind, created_at) VALUES (1, ?, ?, ?)";
    sqlx::query(event).bind(1).bind("operation").bind(at).execute(&mut old).await.unwrap();
    assert!(sqlx::query(event).bind(2).bind("purged").bind(at).execute(&mut old).await.is_err());
    migrations().run(&mut old).await.unwrap();
    assert!(sqlx::query(event).bind(2).bind("other").bind(at).execute(&mut old).await.is_err());
    let purge = "INSERT INTO purges (job, at, reason, archive_sha256) VALUES (1, ?, 'old', zeroblob(32))";
    sqlx::query(purge).bind(at).execute(&mut old).await.unwrap();
    let told: Vec<(i64, String)> =
        sqlx::query_as("SELECT number, kind FROM events ORDER BY number").fetch_all(&mut old).await.unwrap();
    assert_eq!(told, [(1, "operation".to_owned()), (2, "purged".to_owned())]);
    let sound: String = sqlx::query_scalar("PRAGMA integrity_check").fetch_one(&mut old).await.unwrap();
    assert_eq!(sound, "ok");
}
