//! Events of all jobs of a tenant, in one order.

use std::{
    collections::HashMap,
    sync::Arc,
    time::{Duration, Instant},
};

use flankfit::jobs::{EventKind, EventPlace, JobChange, JobPatch, Precondition, RecordKind, Repository, ToldEvent};
use jiff::SignedDuration;
use tokio::{task::JoinSet, time::sleep};
use uuid::Uuid;

use super::{pair::Pair, streams::events};

/// Patience for events behind transactions of others, of which a server may have many.
const PATIENCE: Duration = Duration::from_secs(60);

/// So many events after a place, a few at a time, and no more.
async fn events_after(store: &Arc<dyn Repository>, mut after: EventPlace, count: usize) -> Vec<ToldEvent> {
    let (mut all, begun) = (Vec::new(), Instant::now());
    loop {
        let page = store.all_events(after, 3).await.unwrap();
        if let Some(last) = page.last() {
            assert!(page.len() <= 3 && page[0].place > after, "{page:?}");
            assert!(page.is_sorted_by(|a, b| a.place < b.place), "{page:?}");
            after = last.place;
            all.extend(page);
        } else if all.len() >= count {
            assert_eq!(all.len(), count, "{all:?}");
            return all;
        } else {
            assert!(begun.elapsed() < PATIENCE, "{count} events do not arrive: {all:?}");
            sleep(Duration::from_millis(20)).await;
        }
    }
}

fn named(name: &str) -> JobPatch {
    JobPatch { name: Some(name.to_owned()), ..JobPatch::default() }
}

pub async fn all_events_are_ordered_and_of_one_tenant(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let before = store.last_place().await.unwrap();
    let (one, two) = (place.stored_job(&store).await.id, place.stored_job(&store).await.id);
    place.stored_iteration(&store, two).await;
    let record = place.record(RecordKind::Pitch, "iso_1328_1");
    store.insert_record(two, 1, record.clone(), None).await.unwrap();
    store.patch_job(one, named("renamed"), Precondition::None, place.now()).await.unwrap();
    let others = pair.seen_by("other");
    let theirs = place.stored_job(&others).await.id;
    place.stored_iteration(&others, theirs).await;
    store.delete_job(one, Precondition::None).await.unwrap();
    place.stored_iteration(&store, two).await;

    let all = events_after(&store, before, 6).await;
    let found: Vec<(Uuid, u64)> = all.iter().map(|it| (it.job, it.event.number)).collect();
    // what happened to the job that was deleted went with it
    assert_eq!(found, [(one, 0), (two, 0), (two, 1), (two, 2), (one, 0), (two, 3)]);
    let job = |state| EventKind::Job { state };
    let kinds: Vec<&EventKind> = all.iter().map(|it| &it.event.kind).collect();
    assert_eq!((kinds[0], kinds[1]), (&job(JobChange::Created), &job(JobChange::Created)));
    assert_eq!(kinds[3], &EventKind::Record { number: 1, id: record.id, kind: RecordKind::Pitch });
    assert_eq!(kinds[4], &job(JobChange::Deleted));
    // those of the job are the same
    let own = events(&store, two).await;
    assert!(all.iter().filter(|it| it.event.number > 0).map(|it| &it.event).eq(&own), "{own:?}");
    // on from anywhere, and after the store was opened again
    pair.reopen().await;
    let store = pair.store.clone();
    for (k, event) in all.iter().enumerate() {
        assert_eq!(events_after(&store, event.place, 5 - k).await, all[k + 1..]);
    }
    assert_eq!(events_after(&store, store.last_place().await.unwrap(), 0).await, []);
    let their_events = events_after(&pair.seen_by("other"), before, 2).await;
    assert!(their_events.iter().all(|it| it.job == theirs), "{their_events:?}");
    store.patch_job(two, JobPatch::default(), Precondition::None, place.now()).await.unwrap(); // changes nothing
    store.patch_job(two, named("renamed"), Precondition::None, place.now()).await.unwrap();
    let last = events_after(&store, all[5].place, 1).await;
    assert_eq!(&last[0].event.kind, &job(JobChange::Changed));
    assert_eq!(events(&store, two).await.last(), Some(&last[0].event));
}

/// A reader misses nothing and gets nothing twice while many write at once.
pub async fn concurrent_writes_are_read_exactly_once(pair: &mut Pair) {
    const EACH: usize = 8;
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let mut after = store.last_place().await.unwrap();
    let mut jobs = Vec::new();
    for _ in 0..4 {
        jobs.push(place.stored_job(&store).await.id);
    }
    let mut writers = JoinSet::new();
    for job in jobs.clone() {
        let (store, place) = (store.clone(), place.clone());
        writers.spawn(async move {
            for _ in 0..EACH {
                place.stored_iteration(&store, job).await;
            }
        });
    }
    let (mut found, begun) = (HashMap::<Uuid, Vec<u64>>::new(), Instant::now());
    while found.values().map(Vec::len).sum::<usize>() < jobs.len() * (EACH + 1) {
        assert!(begun.elapsed() < PATIENCE, "{found:?}");
        let page = store.all_events(after, 5).await.unwrap();
        for event in &page {
            found.entry(event.job).or_default().push(event.event.number);
        }
        match page.last() {
            Some(last) => after = last.place,
            None => sleep(Duration::from_millis(2)).await,
        }
    }
    writers.join_all().await;
    for job in jobs {
        assert!(found[&job].iter().copied().eq(0..=EACH as u64), "{:?}", found[&job]);
    }
}

/// The common order expires by its age, of every tenant, and requests for expired parts are
/// refused; the jobs' own events stay.
pub async fn old_events_leave_the_common_order(pair: &mut Pair) {
    let (store, place, others) = (pair.store.clone(), pair.values.clone(), pair.seen_by("other"));
    let first = store.last_place().await.unwrap();
    let (job, theirs) = (place.stored_job(&store).await.id, place.stored_job(&others).await.id);
    place.stored_iteration(&store, job).await;
    let old = events_after(&store, first, 2).await;
    pair.ground.settled().await;
    let [one, two] = &pair.handles;
    // what is as old as the time given is not from before it
    let begun = place.now();
    assert_eq!(one.forget_event_order(begun, begun, 10).await.unwrap(), 0);
    place.stored_iteration(&store, job).await;
    let young = events_after(&store, old[1].place, 1).await;
    pair.ground.settled().await;
    // noted once an hour: by this the young one is not covered yet
    assert_eq!(two.forget_event_order(begun + SignedDuration::from_mins(59), begun, 10).await.unwrap(), 0);
    let later = begun + SignedDuration::from_hours(2);
    assert_eq!(two.forget_event_order(later, begun, 10).await.unwrap(), 0);
    assert!(store.has_all_after(first).await.unwrap());
    assert_eq!(events_after(&store, first, 3).await[2..], young);

    // everything up to `begun`
    let before = begun + SignedDuration::from_mins(90);
    assert_eq!(one.forget_event_order(later, before, 2).await.unwrap(), 2);
    assert_eq!(two.forget_event_order(later, before, 2).await.unwrap(), 1);
    assert_eq!(one.forget_event_order(later, before, 2).await.unwrap(), 0);
    pair.reopen().await;
    let (store, others) = (pair.store.clone(), pair.seen_by("other"));
    assert_eq!(events_after(&store, first, 1).await, young);
    assert_eq!(others.all_events(first, 10).await.unwrap(), []);
    for (after, all) in [(first, false), (old[0].place, false), (young[0].place, true)] {
        assert_eq!(store.has_all_after(after).await.unwrap(), all, "{after:?}");
    }
    assert_eq!(events(&store, job).await.len(), 2);
    assert_eq!(others.last_event(theirs).await.unwrap(), 0);

    // and the rest; places are not given again
    let [one, _] = &pair.handles;
    let last = later + SignedDuration::from_hours(1);
    assert_eq!(one.forget_event_order(last, last, 10).await.unwrap(), 1);
    assert!(store.last_place().await.unwrap() >= young[0].place);
    place.stored_iteration(&store, job).await;
    let next = events_after(&store, first, 1).await;
    assert!(next[0].place > young[0].place && next[0].event.number == 3, "{next:?}");
}

/// A note by a clock that was ahead does not count as one of now.
pub async fn a_clock_that_was_ahead_keeps_nothing_for_ever(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let first = store.last_place().await.unwrap();
    place.stored_job(&store).await;
    events_after(&store, first, 1).await;
    pair.ground.settled().await;
    let [one, two] = &pair.handles;
    let now = place.now();
    let (hour, year) = (SignedDuration::from_hours(1), SignedDuration::from_hours(365 * 24));
    assert_eq!(one.forget_event_order(now + year, now - hour, 10).await.unwrap(), 0);
    // it is right again
    assert_eq!(two.forget_event_order(now, now - hour, 10).await.unwrap(), 0);
    assert!(store.has_all_after(first).await.unwrap());
    assert_eq!(one.forget_event_order(now + 2 * hour, now + hour, 10).await.unwrap(), 1);
    assert!(!store.has_all_after(first).await.unwrap());
    // and the note of the future does not hinder later ones
    place.stored_job(&store).await;
    events_after(&store, first, 1).await;
    pair.ground.settled().await;
    assert_eq!(two.forget_event_order(now + 4 * hour, now + hour, 10).await.unwrap(), 0);
    assert_eq!(two.forget_event_order(now + 6 * hour, now + 5 * hour, 10).await.unwrap(), 1);
}
