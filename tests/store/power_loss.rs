//! Acknowledged data are on disk: a sync of the write-ahead log lies between a request and its
//! response.

use std::sync::Arc;

use flankfit::{
    jobs::{Choice, Decision, DecisionEvent, Event, JobPatch, Precondition, RepositoryError, Update},
    store::StoreSettings,
};
use libsqlite3_sys as sqlite;
use sqlx::{
    ConnectOptions, Connection,
    sqlite::{SqliteConnectOptions, SqliteJournalMode, SqliteSynchronous},
};
use tokio::task::JoinSet;

use crate::{
    disk,
    support::{Opened, Place, actor},
};

/// The store as it comes up after a power loss now.
async fn after_power_loss(place: &Place, name: &str) -> Opened {
    let aftermath = place.path(name);
    disk::lose_power(place.file().parent().unwrap(), &aftermath);
    place.open_with(StoreSettings::of_file(aftermath.join("jobs.db"))).await
}

async fn open_watched(place: &Place) -> Opened {
    disk::register();
    place.open_with(StoreSettings::of_file(place.file()).vfs(disk::NAME)).await
}

#[tokio::test]
async fn every_kind_of_write_is_synced_when_it_is_answered() {
    let place = Place::new();
    let store = open_watched(&place).await;
    let log = place.path("jobs.db-wal");
    let none = || Precondition::None;

    let job = place.stored_job(&store).await;
    assert!(disk::is_synced(&log));
    assert_eq!(after_power_loss(&place, "1").await.job(job.id).await.unwrap(), job);

    let (first, _) = place.stored_iteration(&store, job.id).await;
    assert!(disk::is_synced(&log));
    let fit = Arc::new(place.fit(0.5));
    store.insert_fit(job.id, 1, fit.clone(), None).await.unwrap();
    assert!(disk::is_synced(&log));
    let event = || Event { reason: None, by: actor(), created_at: place.now() };
    store.choose(job.id, 1, Choice { fit_id: fit.id, event: event() }, none()).await.unwrap();
    assert!(disk::is_synced(&log));
    store
        .decide(job.id, 1, DecisionEvent { decision: Decision::Accepted, concession: false, event: event() }, none())
        .await
        .unwrap();
    assert!(disk::is_synced(&log));
    let record = place.stored_record(&store, job.id).await;
    assert!(disk::is_synced(&log));
    let patch = JobPatch { machine: Update::Set("K300".into()), ..JobPatch::default() };
    store.patch_job(job.id, patch, none(), place.now()).await.unwrap();
    assert!(disk::is_synced(&log));
    let stream = Arc::new(place.stream(job.id));
    store.insert_stream(stream.clone(), None).await.unwrap();
    assert!(disk::is_synced(&log));
    let block = place.block(stream.id, 1);
    store.insert_block(block.clone(), None).await.unwrap();
    assert!(disk::is_synced(&log));

    let after = after_power_loss(&place, "2").await;
    let (back, state, last) = after.stream_state(stream.id).await.unwrap();
    assert_eq!((back.sequence, state.map(|state| state.sequence), last), (1, Some(1), Some(block.sha256)));
    assert_eq!(after.last_event(job.id).await.unwrap(), store.last_event(job.id).await.unwrap());
    let iteration = after.iteration(job.id, 1).await.unwrap();
    assert_eq!(
        (iteration.id, iteration.fits.iter().find(|fit| fit.chosen).map(|fit| fit.id), iteration.fits.len()),
        (first.id, Some(fit.id), 2)
    );
    assert_eq!(iteration.decision.unwrap().decision, Decision::Accepted);
    assert_eq!(after.record(job.id, 1, record.id).await.unwrap(), *record);
    assert_eq!(after.job(job.id).await.unwrap().machine.as_deref(), Some("K300"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn of_concurrent_writes_every_answered_one_survives_a_power_loss() {
    let place = Arc::new(Place::new());
    let store = Arc::new(open_watched(&place).await);
    let job = place.stored_job(&*store).await.id;
    for round in 0..4 {
        let mut writers = JoinSet::new();
        for _ in 0..24 {
            let (place, store) = (place.clone(), store.clone());
            writers.spawn(async move {
                let (new, stored) = place.stored_iteration(&*store, job).await;
                (stored.number, new.id)
            });
        }
        // The power goes while some writes are acknowledged and others are under way.
        let mut answered = Vec::new();
        while answered.len() < 9 {
            answered.push(writers.join_next().await.unwrap().unwrap());
        }
        let after = after_power_loss(&place, &format!("round {round}")).await;
        for (number, id) in answered {
            assert_eq!(after.iteration(job, number).await.unwrap().id, id);
        }
        while let Some(outcome) = writers.join_next().await {
            outcome.unwrap();
        }
    }
}

#[tokio::test]
async fn the_watched_disk_loses_unsynced_data() {
    disk::register();
    let place = Place::new();
    let mut careless = SqliteConnectOptions::new()
        .filename(place.file())
        .create_if_missing(true)
        .vfs(disk::NAME)
        .journal_mode(SqliteJournalMode::Wal)
        .synchronous(SqliteSynchronous::Normal)
        .connect()
        .await
        .unwrap();
    sqlx::query("CREATE TABLE kept (n INTEGER); PRAGMA wal_checkpoint").execute(&mut careless).await.unwrap();
    sqlx::query("INSERT INTO kept VALUES (1)").execute(&mut careless).await.unwrap();
    assert!(!disk::is_synced(&place.path("jobs.db-wal")));
    let aftermath = place.path("aftermath");
    disk::lose_power(place.file().parent().unwrap(), &aftermath);
    careless.close().await.unwrap();
    let mut after = SqliteConnectOptions::new().filename(aftermath.join("jobs.db")).connect().await.unwrap();
    let kept: i64 = sqlx::query_scalar("SELECT count(*) FROM kept").fetch_one(&mut after).await.unwrap();
    assert_eq!(kept, 0);
}

/// A full disk is no power loss, but it is reported: nothing is stored, and all is well again when
/// there is space.
#[tokio::test]
async fn a_full_disk_is_reported_and_recovered_from() {
    let place = Place::new();
    let store = open_watched(&place).await;
    let job = place.stored_job(&store).await;
    store.store.check_writable(place.now()).await.unwrap();
    for (code, why) in [(sqlite::SQLITE_FULL, "the disk is full"), (sqlite::SQLITE_READONLY, "read-only")] {
        disk::refuse(place.file().parent().unwrap(), Some(code));
        let unavailable = |error: &RepositoryError| {
            assert!(matches!(error, RepositoryError::Unavailable(said) if said.contains(why)), "{error}");
        };
        unavailable(&store.store.check_writable(place.now()).await.unwrap_err());
        unavailable(&store.insert_iteration(place.iteration(job.id), None).await.unwrap_err());
        assert_eq!(store.job(job.id).await.unwrap(), job, "what is there can be read");
    }
    disk::refuse(place.file().parent().unwrap(), None);
    store.store.check_writable(place.now()).await.unwrap();
    let (_, stored) = place.stored_iteration(&store, job.id).await;
    assert_eq!(stored.number, 1, "nothing was half stored");
}

/// If an iteration does not fit on the disk, the store is not ready even if a row would still fit.
#[tokio::test]
async fn a_disk_that_takes_no_iteration_is_not_called_writable() {
    let place = Place::new();
    let store = open_watched(&place).await;
    let job = place.stored_job(&store).await;
    let directory = place.file().parent().unwrap().to_path_buf();
    // three pages with their heads
    disk::fill(&directory, Some(3 * (4096 + 24)));
    let full = |error: RepositoryError| {
        assert!(matches!(&error, RepositoryError::Unavailable(said) if said.contains("the disk is full")), "{error}");
    };
    full(store.insert_iteration(place.iteration(job.id), None).await.unwrap_err());
    full(store.store.check_writable(place.now()).await.unwrap_err());
    disk::fill(&directory, None);
    store.store.check_writable(place.now()).await.unwrap();
    place.stored_iteration(&store, job.id).await;
}
