//! Operations for no caller, and those of a closed store.

use std::collections::BTreeSet;

use flankfit::jobs::RepositoryError;
use futures_util::future::join_all;
use jiff::SignedDuration;

use super::pair::Pair;
use crate::support::receipt;

/// The oldest kept responses expire first, of every tenant, and the stored resources stay.
pub async fn kept_answers_are_forgotten_by_their_age(pair: &mut Pair) {
    let place = pair.values.clone();
    let tenants = ["default", "other"];
    let mut jobs = Vec::new();
    for key in ["1", "2", "3"] {
        for tenant in tenants {
            let job = place.job("wheel");
            pair.seen_by(tenant).insert_job(job.clone(), Some(receipt(key, "POST /v1/jobs"))).await.unwrap();
            jobs.push((tenant, key, job));
        }
    }
    let left = async |pair: &Pair| {
        let mut left = Vec::new();
        for (tenant, key, job) in &jobs {
            let store = pair.seen_by(tenant);
            assert_eq!(store.job(job.id).await.unwrap(), *job);
            if store.answer(key.to_string(), "POST /v1/jobs".to_owned()).await.unwrap().is_some() {
                left.push((*tenant, *key));
            }
        }
        left
    };
    let [one, two] = &pair.handles;
    // what is as old as the time given is not from before it
    let before = jobs[4].2.created_at;
    assert_eq!(one.forget_answers(jobs[0].2.created_at, 10).await.unwrap(), 0);
    assert_eq!(two.forget_answers(before, 3).await.unwrap(), 3);
    assert_eq!(left(pair).await, [("other", "2"), ("default", "3"), ("other", "3")]);
    assert_eq!(one.forget_answers(before, 3).await.unwrap(), 1);
    assert_eq!(two.forget_answers(before, 3).await.unwrap(), 0);
    assert_eq!(one.forget_answers(place.now() + SignedDuration::from_hours(1), 10).await.unwrap(), 2);
    assert_eq!(left(pair).await, []);
    // and the keys are free
    pair.store.insert_job(place.job("again"), Some(receipt("1", "POST /v1/jobs"))).await.unwrap();
}

pub async fn a_store_responds_until_it_is_closed(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    for handle in &pair.handles {
        handle.ping().await.unwrap();
        handle.check_writable(place.now()).await.unwrap();
    }
    let job = place.stored_job(&store).await;
    let handles = pair.handles.clone();
    pair.close().await;
    for handle in &handles {
        assert!(matches!(handle.ping().await, Err(RepositoryError::Unavailable(_))));
        assert!(matches!(handle.check_writable(place.now()).await, Err(RepositoryError::Unavailable(_))));
        assert!(matches!(handle.forget_answers(place.now(), 1).await, Err(RepositoryError::Unavailable(_))));
    }
    assert!(matches!(store.job(job.id).await, Err(RepositoryError::Unavailable(_))));
    assert!(matches!(store.insert_job(place.job("late"), None).await, Err(RepositoryError::Unavailable(_))));
    pair.reopen().await;
    assert_eq!(pair.store.job(job.id).await.unwrap(), job);
}

/// Requests above the length of the queue are not stored, and nothing else is refused because of
/// them.
pub async fn a_full_queue_refuses_only_the_excess(pair: &mut Pair) {
    pair.reopen_narrow(4).await;
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    // all of them are in the queue, or refused, before the first is waited for
    let writes: Vec<_> = (0..500).map(|_| store.insert_iteration(place.iteration(job), None)).collect();
    let (mut numbers, mut refused) = (BTreeSet::new(), 0);
    for outcome in join_all(writes).await {
        match outcome {
            Ok(stored) => assert!(numbers.insert(stored.number)),
            Err(RepositoryError::Overloaded) => refused += 1,
            Err(error) => panic!("{error}"),
        }
    }
    let stored = numbers.len() as u32;
    assert!(refused > 0 && stored >= 4, "{refused} refused, {stored} stored");
    assert!(numbers.into_iter().eq(1..=stored));
    assert_eq!(store.last_event(job).await.unwrap(), u64::from(stored));
}
