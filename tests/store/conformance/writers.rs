//! Many writers at once, through both handles: numbers without gaps, refusals that spoil nothing.

use std::{collections::BTreeSet, sync::Arc};

use flankfit::jobs::{Choice, Decision, DecisionEvent, Event, Precondition, RepositoryError, Resource};
use tokio::task::JoinSet;

use super::pair::Pair;
use crate::support::WHOLE;

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
            let event = Event { reason: Some(i.to_string()), created_at: place.now() };
            let none = Precondition::None;
            let stored = match i % 3 {
                0 => store.insert_fit(job, 1, Arc::new(place.fit(f64::from(i))), None).await,
                1 => store.choose(job, 1, Choice { fit_id: chosen, event }, none).await,
                _ => store.decide(job, 1, DecisionEvent { decision: Decision::Accept, event }, none).await,
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
        let event = Event { reason: Some(format!("late {i}")), created_at: place.now() };
        let decision = DecisionEvent { decision: Decision::Reject, event };
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

pub async fn a_dropped_request_is_stored_all_the_same(pair: &mut Pair) {
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
