//! Many writers at once, through both handles: numbers without gaps, refusals that spoil nothing.

use std::{collections::BTreeSet, sync::Arc};

use flankfit::jobs::{
    Choice, Decision, DecisionEvent, Event, JobPatch, Precondition, Receipt, RecordKind, RepositoryError,
    RepositoryFuture, Resource, Stored,
};
use futures_util::future::join_all;
use tokio::task::JoinSet;

use super::pair::Pair;
use crate::support::{WHOLE, actor, all_jobs, receipt};

pub async fn three_hundred_writers_leave_no_gaps(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
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
        let trace = store.trace(*job, WHOLE).await.unwrap();
        assert!(trace.iterations.iter().map(|iteration| iteration.number).eq(1..=100));
        let events = store.events(*job, 0, 1000).await.unwrap();
        assert!(events.iter().map(|event| event.number).eq(1..=100));
        assert_eq!(store.last_event(*job).await.unwrap(), 100);
    }
}

/// The writer goes on, and what shares a transaction with it is stored.
pub async fn a_write_that_panics_is_refused_alone(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let keyed = |panics: bool| {
        let receipt = receipt("panics", "POST /there");
        let answer = receipt.answer;
        Receipt {
            answer: Box::new(move |stored| if panics { panic!("on purpose") } else { answer(stored) }),
            ..receipt
        }
    };
    for _ in 0..2 {
        let panicking = store.insert_iteration(place.iteration(job), Some(keyed(true)));
        let others = join_all((0..20).map(|_| store.insert_iteration(place.iteration(job), None)));
        let (refused, others) = tokio::join!(panicking, others);
        assert!(matches!(refused, Err(RepositoryError::Failed(_))), "{refused:?}");
        assert!(others.iter().all(Result::is_ok), "{others:?}");
        let record = place.record(RecordKind::Curve, "polynomial");
        let refused = store.insert_record(job, 1, record.clone(), Some(keyed(true))).await;
        assert!(matches!(refused, Err(RepositoryError::Failed(_))), "{refused:?}");
    }
    let stored = store.insert_iteration(place.iteration(job), Some(keyed(false))).await.unwrap();
    assert_eq!((stored.number, store.last_event(job).await.unwrap()), (41, 41));
}

/// Fits, choices and decisions of one iteration: each moves its version on by one, and each is one
/// event.
pub async fn versions_and_events_count_every_change_once(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let (first, _) = place.stored_iteration(&store, job).await;
    let mut tasks = JoinSet::new();
    for i in 0..60_u32 {
        let (place, store, chosen) = (place.clone(), store.clone(), first.fit.id);
        tasks.spawn(async move {
            let event = Event { reason: Some(i.to_string()), by: actor(), created_at: place.now() };
            let none = Precondition::None;
            let stored = match i % 3 {
                0 => store.insert_fit(job, 1, Arc::new(place.fit(f64::from(i))), None).await,
                1 => store.choose(job, 1, Choice { fit_id: chosen, event }, none).await,
                _ => {
                    store
                        .decide(job, 1, DecisionEvent { decision: Decision::Accepted, concession: false, event }, none)
                        .await
                }
            };
            stored.unwrap().version
        });
    }
    let versions: BTreeSet<u64> = tasks.join_all().await.into_iter().collect();
    assert!(versions.into_iter().eq(2..=61));
    assert_eq!(store.iteration(job, 1).await.unwrap().version, 61);
    let events = store.events(job, 0, 1000).await.unwrap();
    assert!(events.iter().map(|event| event.number).eq(1..=61));
    // of those that have seen one version, one goes on
    let mut tasks = JoinSet::new();
    for i in 0..20 {
        let (place, store) = (place.clone(), store.clone());
        let event = Event { reason: Some(format!("late {i}")), by: actor(), created_at: place.now() };
        let decision = DecisionEvent { decision: Decision::Rejected, concession: false, event };
        tasks.spawn(async move { store.decide(job, 1, decision, Precondition::AnyOf(vec![61])).await });
    }
    let outcomes = tasks.join_all().await;
    assert_eq!(outcomes.iter().filter(|outcome| outcome.is_ok()).count(), 1);
    let late = |outcome: &Result<_, _>| matches!(outcome, Err(RepositoryError::VersionMismatch { current: 62 }));
    assert_eq!(outcomes.iter().filter(|outcome| late(outcome)).count(), 19);
}

pub async fn one_request_that_the_store_refuses_does_not_take_others_along(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    // Ids of jobs are unique; nothing checks that before the insert.
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
    let refused = outcomes.iter().filter(|outcome| matches!(outcome, Err(RepositoryError::Failed(_)))).count();
    assert_eq!(refused, 3, "one twin is stored, the other three are refused");
    let numbers: BTreeSet<u32> = outcomes.into_iter().flatten().filter(|number| *number > 0).collect();
    assert!(numbers.into_iter().eq(1..=36));
}

pub async fn a_dropped_request_is_stored(pair: &mut Pair) {
    let (store, place) = (pair.handles[0].of(&crate::support::caller("default")), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    for _ in 0..5 {
        drop(store.insert_iteration(place.iteration(job), None));
    }
    // Requests of one handle for one job are served in the order of arrival, so this one comes
    // after them.
    let (_, stored) = place.stored_iteration(&store, job).await;
    assert_eq!(stored.number, 6);
}

/// One of several changes based on one version of a job is made; changes without a version are all
/// made.
pub async fn a_job_is_changed_once_from_each_version(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let change = |i: u32, precondition| {
        let (store, place) = (store.clone(), place.clone());
        let patch = JobPatch { name: Some(format!("wheel {i}")), ..JobPatch::default() };
        async move { store.patch_job(job, patch, precondition, place.now()).await }
    };
    let outcomes = join_all((0..20).map(|i| change(i, Precondition::AnyOf(vec![1])))).await;
    let (made, late): (Vec<_>, Vec<_>) = outcomes.into_iter().partition(Result::is_ok);
    assert_eq!(made.len(), 1);
    let mismatch = |late: &Result<_, _>| matches!(late, Err(RepositoryError::VersionMismatch { current: 2 }));
    assert!(late.iter().all(mismatch));
    let outcomes = join_all((20..40).map(|i| change(i, Precondition::None))).await;
    let versions: BTreeSet<u64> = outcomes.into_iter().map(|outcome| outcome.unwrap().version).collect();
    assert!(versions.into_iter().eq(3..=22));
    assert_eq!(store.job(job).await.unwrap().version, 22);
}

/// A job is deleted, or it has got something: never both, and nothing is left of a deleted one.
pub async fn a_job_is_deleted_or_gets_something(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    for i in 0..20 {
        let job = place.stored_job(&store).await.id;
        let stream = Arc::new(place.stream(job));
        let (added, deleted) = match i % 2 {
            0 => tokio::join!(
                store.insert_iteration(place.iteration(job), None),
                store.delete_job(job, Precondition::None)
            ),
            _ => tokio::join!(store.insert_stream(stream, None), store.delete_job(job, Precondition::None)),
        };
        match (added, deleted) {
            (Ok(_), Err(RepositoryError::HasIterations(1) | RepositoryError::HasStreams(1))) => {
                assert_eq!(store.last_event(job).await.unwrap(), 1);
            }
            (Err(RepositoryError::NotFound(Resource::Job)), Ok(())) => {
                assert_eq!(store.events(job, 0, 10).await.unwrap(), []);
            }
            both => panic!("{both:?}"),
        }
    }
}

/// Writes of one key at the same time, also where they are of different kinds and jobs: one stores.
pub async fn a_key_is_used_once_by_concurrent_writers(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let jobs = [place.stored_job(&store).await.id, place.stored_job(&store).await.id];
    for round in 0..5 {
        let key = format!("key {round}");
        let keyed = || Some(receipt(&key, "POST /there"));
        let writes: Vec<RepositoryFuture<'_, Stored>> = (0..24)
            .map(|i| match i % 4 {
                0 => store.insert_job(place.job("new"), keyed()),
                1 => store.insert_stream(Arc::new(place.stream(jobs[0])), keyed()),
                2 => store.insert_runs(Vec::new(), keyed(), place.now()),
                _ => store.insert_iteration(place.iteration(jobs[i % 8 / 4]), keyed()),
            })
            .collect();
        let outcomes = join_all(writes).await;
        assert_eq!(outcomes.iter().filter(|outcome| outcome.is_ok()).count(), 1, "{outcomes:?}");
        let taken = |outcome: &&Result<_, _>| matches!(outcome, Err(RepositoryError::KeyTaken));
        assert_eq!(outcomes.iter().filter(taken).count(), 23, "{outcomes:?}");
    }
    let mut stored = store.jobs(all_jobs()).await.unwrap().items.len() - 2;
    for job in jobs {
        stored += store.events(job, 0, 1000).await.unwrap().len();
    }
    assert!(stored <= 5, "{stored} things were stored under five keys");
}
