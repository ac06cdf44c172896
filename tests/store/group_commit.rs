//! Writes that share a commit, on a database that others use or have damaged.

use flankfit::jobs::{RecordKind, RepositoryError, Resource};
use sqlx::Row;

use crate::support::{Place, WHOLE};

#[tokio::test]
async fn another_programs_transaction_is_waited_for() {
    let place = Place::new();
    let store = place.open().await;
    let job = place.stored_job(&store).await.id;
    let mut other = place.connect().await;
    sqlx::query("BEGIN IMMEDIATE").execute(&mut other).await.unwrap();
    let waiting = store.insert_iteration(place.iteration(job), None);
    // Reading goes on while the other program writes.
    assert_eq!(store.trace(job, WHOLE).await.unwrap().iterations.len(), 0);
    let count: i64 = sqlx::query("SELECT count(*) FROM iterations").fetch_one(&mut other).await.unwrap().get(0);
    assert_eq!(count, 0);
    sqlx::query("COMMIT").execute(&mut other).await.unwrap();
    assert_eq!(waiting.await.unwrap().number, 1);
}

/// A job whose row does not read refuses its own iterations; those that wait with them are stored.
#[tokio::test]
async fn a_damaged_job_does_not_take_its_group_along() {
    let place = Place::new();
    let store = place.open().await;
    let [sound, damaged] = [place.stored_job(&store).await.id, place.stored_job(&store).await.id];
    let mut other = place.connect().await;
    let spoil = "UPDATE jobs SET gear = CAST(x'ff' AS TEXT) WHERE id = ?";
    sqlx::query(spoil).bind(damaged).execute(&mut other).await.unwrap();
    // while another program writes, all of these wait for one transaction
    sqlx::query("BEGIN IMMEDIATE").execute(&mut other).await.unwrap();
    let waiting = [sound, damaged, sound, damaged].map(|job| store.insert_iteration(place.iteration(job), None));
    let new_job = store.insert_job(place.job("another"), None);
    sqlx::query("COMMIT").execute(&mut other).await.unwrap();
    let outcomes = futures_util::future::join_all(waiting).await;
    let numbers: Vec<Option<u32>> =
        outcomes.iter().map(|outcome| outcome.as_ref().ok().map(|stored| stored.number)).collect();
    assert_eq!(numbers, [Some(1), None, Some(2), None]);
    for refused in [&outcomes[1], &outcomes[3]] {
        let why = refused.as_ref().unwrap_err();
        assert!(matches!(why, RepositoryError::Failed(why) if why.contains("gear")), "{why}");
    }
    new_job.await.unwrap();
}

/// An iteration without a fit, which nothing of this program stores, is damage and no version 0.
#[tokio::test]
async fn an_iteration_without_a_fit_is_called_damaged() {
    let place = Place::new();
    let store = place.open().await;
    let job = place.stored_job(&store).await.id;
    let mut other = place.connect().await;
    let bare =
        "INSERT INTO iterations (id, job, number, created_at) SELECT ?, id, 1, created_at FROM jobs WHERE id = ?";
    sqlx::query(bare).bind(place.id()).bind(job).execute(&mut other).await.unwrap();
    let record = place.record(RecordKind::Curve, "lagrange");
    let damage = store.insert_record(job, 1, record.clone(), None).await.unwrap_err();
    assert!(matches!(&damage, RepositoryError::Failed(why) if why.contains("cannot be read: -1")), "{damage}");
    let missing = store.insert_record(job, 2, record, None).await.unwrap_err();
    assert!(matches!(missing, RepositoryError::NotFound(Resource::Iteration)), "{missing}");
}
