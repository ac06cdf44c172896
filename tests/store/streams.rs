//! Databases from before there were events are told of from their beginning.

use flankfit::store::migrations;
use sqlx::{AssertSqlSafe, ConnectOptions, sqlite::SqliteConnectOptions};

use crate::{
    conformance::streams::{events, kinds},
    support::Place,
};

#[tokio::test]
async fn what_happened_before_there_were_events_is_told_too() {
    let place = Place::new();
    let mut old = SqliteConnectOptions::new().filename(place.file()).create_if_missing(true).connect().await.unwrap();
    migrations().run_to(4, &mut old).await.unwrap();
    let job = place.id();
    let at = |second: u32| format!("'2026-01-02T03:04:{second:02}.000006Z'");
    let text =
        format!(
        "INSERT INTO jobs (id, name, tags, version, created_at, updated_at) VALUES (x'{}', 'old', '{{}}', 1, {t0}, \
         {t0});
         INSERT INTO iterations (seq, id, job, number, created_at) VALUES (1, zeroblob(16), 1, 1, {t1}), (2, \
         zeroblob(16), 1, 2, {t3});
         INSERT INTO fits (seq, id, iteration, created_at, spec, result)
         VALUES (1, zeroblob(16), 1, {t1}, '{{}}', '{{}}'), (2, zeroblob(16), 1, {t2}, '{{}}', '{{}}'), (3, \
         zeroblob(16), 2, {t3}, '{{}}', '{{}}');
         INSERT INTO fit_choices (iteration, position, fit, created_at) VALUES (1, 1, 1, {t1}), (1, 2, 2, {t4}), (2, \
         1, 3, {t3});
         INSERT INTO decisions (iteration, position, decision, reason, created_at) VALUES (1, 1, 'remachine', 'slope', \
         {t2}), (2, 1, 'accept', NULL, {t5});",
        job.simple(),
        t0 = at(0), t1 = at(1), t2 = at(2), t3 = at(3), t4 = at(4), t5 = at(5),
    );
    sqlx::raw_sql(AssertSqlSafe(text)).execute(&mut old).await.unwrap();
    sqlx::Connection::close(old).await.unwrap();

    let store = place.open().await;
    let told = ["iteration", "fit", "decision", "iteration", "choice", "decision"];
    assert_eq!(kinds(&events(&store.repository, job).await), told);
    place.stored_iteration(&store, job).await;
    assert_eq!(store.last_event(job).await.unwrap(), 7);
    assert_eq!(kinds(&store.events(job, 5, 1).await.unwrap()), ["decision"]);
    assert_eq!(kinds(&store.events(job, 6, 10).await.unwrap()), ["iteration"]);
}
