//! Writes that share a commit: numbers without gaps, refusals that spoil nothing, keys that store
//! once.

use std::{collections::BTreeSet, sync::Arc};

use flankfit::jobs::{Answer, KeyedRequest, Receipt, RecordKind, Repository, RepositoryError, Resource};
use sqlx::Row;
use tokio::task::JoinSet;

use crate::support::{Place, WHOLE};

fn receipt(key: &str) -> Receipt {
    Receipt {
        request: KeyedRequest {
            key: key.to_owned(),
            scope: "POST /v1/jobs/1/iterations".to_owned(),
            request_sha256: [7; 32],
            claim: None,
        },
        answer: Box::new(|stored| Answer {
            status: 201,
            location: Some("/there".to_owned()),
            etag: None,
            body: format!("{{\"number\":{}}}", stored.number).into_bytes(),
        }),
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn numbers_have_no_gaps_though_some_requests_are_refused() {
    let place = Arc::new(Place::new());
    let store = Arc::new(place.open().await);
    let jobs = [place.stored_job(&store).await.id, place.stored_job(&store).await.id];
    let mut tasks = JoinSet::new();
    for i in 0..300 {
        let (place, store) = (place.clone(), store.clone());
        tasks.spawn(async move {
            // Every third request names a job that does not exist, and shares its commit with
            // others.
            let job = if i % 3 == 2 { place.id() } else { jobs[i % 3] };
            (job, store.insert_iteration(place.iteration(job), None).await)
        });
    }
    let mut numbers = [BTreeSet::new(), BTreeSet::new()];
    while let Some(outcome) = tasks.join_next().await {
        let (job, outcome) = outcome.unwrap();
        match jobs.iter().position(|known| *known == job) {
            Some(index) => assert!(numbers[index].insert(outcome.unwrap().number), "a number was given twice"),
            None => assert!(matches!(outcome, Err(RepositoryError::NotFound(Resource::Job)))),
        }
    }
    for (job, numbers) in jobs.iter().zip(&numbers) {
        assert!(numbers.iter().copied().eq(1..=100));
        let stored: Vec<u32> =
            store.trace(*job, WHOLE).await.unwrap().iterations.iter().map(|iteration| iteration.number).collect();
        assert!(stored.into_iter().eq(1..=100));
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_key_stores_once_and_its_answer_outlives_the_process() {
    let place = Arc::new(Place::new());
    let job;
    {
        let store = Arc::new(place.open().await);
        job = place.stored_job(&store).await.id;
        let mut tasks = JoinSet::new();
        for _ in 0..20 {
            let (place, store) = (place.clone(), store.clone());
            tasks.spawn(async move { store.insert_iteration(place.iteration(job), Some(receipt("once"))).await });
        }
        let outcomes = tasks.join_all().await;
        assert_eq!(outcomes.iter().filter(|outcome| outcome.is_ok()).count(), 1);
        assert!(outcomes.iter().all(|outcome| matches!(outcome, Ok(_) | Err(RepositoryError::KeyTaken))));
        store.close().await;
        let late = store.insert_iteration(place.iteration(job), None).await;
        assert!(matches!(late, Err(RepositoryError::Unavailable(_))));
    }
    let store = place.open().await;
    let kept = store.answer("once".into(), "POST /v1/jobs/1/iterations".into()).await.unwrap();
    let (digest, answer) = kept.unwrap();
    assert_eq!((digest, answer.status, answer.location.as_deref()), ([7; 32], 201, Some("/there")));
    assert_eq!(answer.body, br#"{"number":1}"#);
    assert_eq!(store.answer("once".into(), "POST /elsewhere".into()).await.unwrap(), None);
    assert_eq!(store.trace(job, WHOLE).await.unwrap().iterations.len(), 1);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn one_request_that_the_database_refuses_does_not_take_its_group_along() {
    let place = Arc::new(Place::new());
    let store = Arc::new(place.open().await);
    let job = place.stored_job(&store).await.id;
    // Ids of jobs are unique; nothing checks that before the insert, so the group fails as a whole
    // and is tried one by one.
    let twin = place.job("twin");
    let mut tasks = JoinSet::new();
    for i in 0..40 {
        let (place, store, twin) = (place.clone(), store.clone(), twin.clone());
        tasks.spawn(async move {
            if i % 10 == 0 {
                store.insert_job(twin, None).await.map(|_| 0)
            } else {
                store.insert_iteration(place.iteration(job), None).await.map(|stored| stored.number)
            }
        });
    }
    let outcomes = tasks.join_all().await;
    let refused = outcomes.iter().filter(|outcome| outcome.is_err()).count();
    assert_eq!(refused, 3, "one twin is stored, the other three are refused");
    let numbers: BTreeSet<u32> = outcomes.into_iter().flatten().filter(|number| *number > 0).collect();
    assert!(numbers.into_iter().eq(1..=36));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_dropped_request_is_stored_all_the_same() {
    let place = Place::new();
    let store = place.open().await;
    let job = place.stored_job(&store).await.id;
    for _ in 0..5 {
        drop(store.insert_iteration(place.iteration(job), None));
    }
    // Requests are served in the order of arrival, so this one comes after them.
    let (_, stored) = place.stored_iteration(&store, job).await;
    assert_eq!(stored.number, 6);
}

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
        "INSERT INTO iterations (id, job, number, created_at) SELECT ?, seq, 1, created_at FROM jobs WHERE id = ?";
    sqlx::query(bare).bind(place.id()).bind(job).execute(&mut other).await.unwrap();
    let record = place.record(RecordKind::Curve, "lagrange");
    let damage = store.insert_record(job, 1, record.clone(), None).await.unwrap_err();
    assert!(matches!(&damage, RepositoryError::Failed(why) if why.contains("cannot be read: -1")), "{damage}");
    let missing = store.insert_record(job, 2, record, None).await.unwrap_err();
    assert!(matches!(missing, RepositoryError::NotFound(Resource::Iteration)), "{missing}");
}
