//! One writer, and the life of what it keeps.

use std::{
    sync::{
        Arc,
        atomic::{AtomicI64, Ordering},
    },
    time::{Duration, Instant},
};

use flankfit::{
    jobs::{
        Answer, Clock, EVENTS_TOLD, Job, JobDraft, JobService, Keyed, KeyedRequest, OrderedIds, Store as _,
        SystemClock, Upkeep as _,
    },
    store::{OpenError, PostgresSettings, StoreSettings, open_postgres, open_sqlite},
};
use jiff::Timestamp;
use sqlx::{Connection as _, PgConnection};

use crate::{
    server::Server,
    support::{Place, Values, all_jobs, caller, still},
};

/// Times for which data are kept, in seconds, as the documents promise.
const HOUR: i64 = 3600;
const WEEK: i64 = 7 * 24 * HOUR;
const THIRTY_DAYS: i64 = 30 * 24 * HOUR;
/// Time within which data expire.
const PATIENCE: Duration = Duration::from_secs(60);

#[tokio::test]
async fn a_second_writer_is_refused_and_the_next_one_is_not() {
    let place = Place::new();
    let first = place.open().await;
    let refused = open_sqlite(StoreSettings::of_file(place.file()), still(place.now())).await.err();
    assert!(matches!(refused, Some(OpenError::InUse { .. })), "{refused:?}");
    assert!(refused.unwrap().to_string().contains("another flankfit writes it"));
    // by another name it is the same database
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(place.file(), place.path("other.db")).unwrap();
        let refused = open_sqlite(StoreSettings::of_file(place.path("other.db")), still(place.now())).await.err();
        assert!(matches!(refused, Some(OpenError::InUse { .. })), "{refused:?}");
    }
    first.close().await;
    let second = place.open().await;
    place.stored_job(&second).await;
    // reading needs no lock
    flankfit::store::backup(&StoreSettings::of_file(place.file()), &place.path("copy.db")).await.unwrap();
    drop(second);
    // whoever is gone without closing lets go too
    let dropped = Instant::now();
    let third = loop {
        match open_sqlite(StoreSettings::of_file(place.file()), still(place.now())).await {
            Ok(store) => break store,
            Err(OpenError::InUse { .. }) => assert!(dropped.elapsed() < PATIENCE, "nobody lets go of it"),
            Err(error) => panic!("{error}"),
        }
    };
    third.close().await;
}

/// A clock that advances only when it is moved.
#[derive(Clone)]
struct Hands(Arc<AtomicI64>);

impl Clock for Hands {
    fn now(&self) -> Timestamp {
        Timestamp::from_second(self.0.load(Ordering::SeqCst)).unwrap()
    }
}

fn keyed(key: &str) -> Keyed<Job> {
    Keyed {
        request: KeyedRequest {
            key: key.to_owned(),
            scope: "POST /v1/jobs".to_owned(),
            request_sha256: [0; 32],
            claim: None,
        },
        answer: Box::new(|_, _| Answer { status: 201, location: None, etag: None, body: Vec::new() }),
    }
}

#[tokio::test]
async fn stored_responses_expire_while_the_service_runs() {
    let place = Place::new();
    let store = place.open().await;
    let hands = Hands(Arc::new(AtomicI64::new(place.now().as_second())));
    let service = JobService::new(store.store.clone(), Arc::new(hands.clone()), Arc::new(OrderedIds::new()));
    let jobs = service.of(&caller("default"));
    let draft = || JobDraft { name: "wheel".to_owned(), ..JobDraft::default() };
    let kept = async |key: &str| store.answer(key.to_owned(), "POST /v1/jobs".to_owned()).await.unwrap().is_some();
    jobs.create_job(draft(), Some(keyed("old"))).await.unwrap();
    hands.0.fetch_add(THIRTY_DAYS - 10, Ordering::SeqCst);
    jobs.create_job(draft(), Some(keyed("new"))).await.unwrap();
    service.forget_old_answers().await.unwrap();
    assert!(kept("old").await && kept("new").await);
    hands.0.fetch_add(20, Ordering::SeqCst);
    service.forget_old_answers().await.unwrap();
    assert!(!kept("old").await && kept("new").await);
    // and by itself, now and then
    hands.0.fetch_add(THIRTY_DAYS, Ordering::SeqCst);
    let upkeep = tokio::spawn({
        let service = service.clone();
        async move { service.upkeep(Duration::from_millis(1)).await }
    });
    while kept("new").await {
        tokio::task::yield_now().await;
    }
    upkeep.abort();
    assert_eq!(store.jobs(all_jobs()).await.unwrap().items.len(), 2, "only answers go");
}

#[tokio::test]
async fn old_events_are_forgotten_while_the_service_runs() {
    let place = Place::new();
    let store = place.open().await;
    let hands = Hands(Arc::new(AtomicI64::new(place.now().as_second())));
    let service = JobService::new(store.store.clone(), Arc::new(hands.clone()), Arc::new(OrderedIds::new()));
    let jobs = service.of(&caller("default"));
    let first = jobs.last_place().await.unwrap();
    jobs.create_job(JobDraft { name: "wheel".to_owned(), ..JobDraft::default() }, None).await.unwrap();
    service.forget_old_events().await.unwrap();
    hands.0.fetch_add(WEEK, Ordering::SeqCst);
    service.forget_old_events().await.unwrap();
    assert!(jobs.has_all_after(first).await.unwrap(), "events of that age are kept");
    assert_eq!(jobs.all_events(first, 10).await.unwrap().len(), 1);
    // by itself, now and then
    hands.0.fetch_add(1, Ordering::SeqCst);
    let upkeep = tokio::spawn({
        let service = service.clone();
        async move { service.upkeep(Duration::from_millis(1)).await }
    });
    while jobs.has_all_after(first).await.unwrap() {
        tokio::task::yield_now().await;
    }
    upkeep.abort();
    assert_eq!(jobs.all_events(first, 10).await.unwrap(), []);
    assert!(jobs.last_place().await.unwrap() > first);
}

/// A dump contains events of a server whose transactions had larger numbers.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn events_of_another_server_hide_no_local_events() {
    let url = Server::shared().database().await;
    let mut db = PgConnection::connect(&url).await.unwrap();
    let brought = "INSERT INTO told_until (at, changed_by, gone) VALUES (now() - interval '8 days', 4000000000, true);
                   INSERT INTO told (tenant, changed_by, job, state, created_at)
                   VALUES ('default', 4000000001, gen_random_uuid(), 'created', now() - interval '8 days')";
    sqlx::raw_sql(brought).execute(&mut db).await.unwrap();
    let mut settings = PostgresSettings::of_url(&url).unwrap();
    settings.unsafe_store = true;
    let store = open_postgres(settings, Arc::new(OrderedIds::new()), Arc::new(SystemClock)).await.unwrap();
    let (repository, values) = (store.of(&caller("default")), Values::default());
    let first = repository.last_place().await.unwrap();
    assert!(repository.has_all_after(first).await.unwrap());
    values.stored_job(&repository).await;
    let now = SystemClock.now();
    for _ in 0..2 {
        assert_eq!(store.forget_event_order(now, now - EVENTS_TOLD, 100).await.unwrap(), 0);
        assert!(repository.has_all_after(first).await.unwrap());
    }
    let left: Vec<i64> = sqlx::query_scalar("SELECT changed_by FROM told").fetch_all(&mut db).await.unwrap();
    assert!(left.len() == 1 && left[0] < 4_000_000_000, "{left:?}");
    db.close().await.unwrap();
    store.close().await;
}
