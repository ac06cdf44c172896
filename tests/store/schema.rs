//! Changes that the database itself refuses to every writer.

use std::sync::Arc;

use flankfit::jobs::{Answer, NewFit, Receipt};
use sqlx::{AssertSqlSafe, Row, SqliteConnection};
use uuid::Uuid;

use crate::support::{Place, receipt};

async fn refusal(connection: &mut SqliteConnection, sql: &str) -> String {
    let outcome = sqlx::query(AssertSqlSafe(sql.to_owned())).execute(connection).await;
    outcome.expect_err(sql).to_string()
}

#[tokio::test]
async fn every_table_is_strict() {
    let place = Place::new();
    let store = place.open().await;
    place.stored_iteration(&store, place.stored_job(&store).await.id).await;
    let mut own = place.connect().await;
    let loose: Vec<String> = sqlx::query_scalar(
        "SELECT name FROM pragma_table_list WHERE type = 'table' AND strict = 0
         AND name NOT LIKE 'sqlite_%' AND name NOT LIKE '_sqlx_%'",
    )
    .fetch_all(&mut own)
    .await
    .unwrap();
    assert_eq!(loose, Vec::<String>::new());

    let at = "'2026-11-21T08:00:00.000001Z'";
    let decision = |number: u32, position: &str, decision: &str, at: &str| {
        format!(
            "INSERT INTO decisions (job, number, position, decision, created_at)
             SELECT id, {number}, {position}, '{decision}', {at} FROM jobs"
        )
    };
    let wrong_type = refusal(&mut own, &decision(1, "'one'", "accepted", at)).await;
    assert!(wrong_type.contains("cannot store TEXT value in INTEGER column"), "{wrong_type}");
    let wrong_word = refusal(&mut own, &decision(1, "1", "perhaps", at)).await;
    assert!(wrong_word.contains("CHECK constraint failed"), "{wrong_word}");
    let wrong_time = refusal(&mut own, &decision(1, "1", "accepted", "'today'")).await;
    assert!(wrong_time.contains("CHECK constraint failed"), "{wrong_time}");
    let no_iteration = refusal(&mut own, &decision(99, "1", "accepted", at)).await;
    assert!(no_iteration.contains("FOREIGN KEY constraint failed"), "{no_iteration}");
    let twice = refusal(
        &mut own,
        &format!("INSERT INTO iterations (id, job, number, created_at) SELECT zeroblob(16), id, 1, {at} FROM jobs"),
    )
    .await;
    assert!(twice.contains("UNIQUE constraint failed"), "{twice}");
}

#[tokio::test]
async fn a_choice_of_another_iterations_fit_is_refused() {
    let place = Place::new();
    let store = place.open().await;
    let job = place.stored_job(&store).await;
    place.stored_iteration(&store, job.id).await;
    place.stored_iteration(&store, job.id).await;
    let mut own = place.connect().await;
    let choice = "INSERT INTO fit_choices (job, number, position, fit, created_at)
                  SELECT id, 1, 2, 2, '2026-11-21T08:00:00.000001Z' FROM jobs";
    let foreign = refusal(&mut own, choice).await;
    assert!(foreign.contains("FOREIGN KEY constraint failed"), "{foreign}");
}

/// The response to a new iteration or fit is kept without the stored result in it.
#[tokio::test]
async fn a_result_is_stored_once() {
    let place = Place::new();
    let store = place.open().await;
    let job = place.stored_job(&store).await.id;
    let receipt_with_result = |key: &str, fit: &NewFit| {
        let body = format!(r#"{{"fits":[{{"result":{}}}]}}"#, fit.computed.result.text()).into_bytes();
        let answer = move |_| Answer { status: 201, location: None, etag: None, body: body.clone() };
        Some(Receipt { answer: Box::new(answer), ..receipt(key, "POST /there") })
    };
    let (iteration, fit) = (place.iteration(job), Arc::new(place.fit(0.25)));
    store.insert_iteration(iteration.clone(), receipt_with_result("iteration", &iteration.fit)).await.unwrap();
    store.insert_fit(job, 1, fit.clone(), receipt_with_result("fit", &fit)).await.unwrap();
    let mut own = place.connect().await;
    let kept: Vec<(String, Vec<u8>, Vec<u8>, Uuid)> = sqlx::query_as(
        "SELECT key, body, body_end, f.id FROM idempotency_keys k
         JOIN fits f ON f.job = k.job AND f.number = k.number AND f.position = k.fit ORDER BY k.fit",
    )
    .fetch_all(&mut own)
    .await
    .unwrap();
    let around = |key: &str, fit| (key.to_owned(), br#"{"fits":[{"result":"#.to_vec(), b"}]}".to_vec(), fit);
    assert_eq!(kept, [around("iteration", iteration.fit.id), around("fit", fit.id)]);
}

#[tokio::test]
async fn the_log_is_written_ahead_and_synced_in_full() {
    let place = Place::new();
    let store = place.open().await;
    place.stored_job(&store).await;
    let mut own = place.connect().await;
    let mode: String = sqlx::query("PRAGMA journal_mode").fetch_one(&mut own).await.unwrap().get(0);
    assert_eq!(mode, "wal");
    let broken: Vec<String> = sqlx::query_scalar("PRAGMA integrity_check").fetch_all(&mut own).await.unwrap();
    assert_eq!(broken, ["ok"]);
}
