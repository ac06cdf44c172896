//! Streams and events: blocks in order, and every event once.

use std::sync::Arc;

use flankfit::jobs::{
    EventKind, FinishedStream, JobEvent, NewBlock, PageRequest, Precondition, Repository, RepositoryError, Resource,
    StreamEvent,
};
use tokio::task::JoinSet;
use uuid::Uuid;

use super::pair::Pair;

pub fn kinds(events: &[JobEvent]) -> Vec<&'static str> {
    events
        .iter()
        .map(|event| match &event.kind {
            EventKind::Iteration { .. } => "iteration",
            EventKind::Fit { chosen: false, .. } => "fit",
            EventKind::Fit { chosen: true, .. } => "choice",
            EventKind::Decision { .. } => "decision",
            EventKind::Stream { state, .. } => state.name(),
            EventKind::Record { .. } => "record",
            EventKind::Job { .. } => "job",
            EventKind::Purged { .. } => "purged",
        })
        .collect()
}

pub async fn events(store: &Arc<dyn Repository>, job: Uuid) -> Vec<JobEvent> {
    let events = store.events(job, 0, 1000).await.unwrap();
    assert!(events.iter().map(|event| event.number).eq(1..=events.len() as u64));
    events
}

pub async fn blocks_are_accepted_in_order_from_concurrent_writers(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let stream = Arc::new(place.stream(job));
    store.insert_stream(stream.clone(), None).await.unwrap();
    for sequence in 1..=5 {
        let mut writers = JoinSet::new();
        for _ in 0..6 {
            let (store, block) = (store.clone(), place.block(stream.id, sequence));
            writers.spawn(async move { store.insert_block(block, None).await });
        }
        let outcomes = writers.join_all().await;
        assert_eq!(outcomes.iter().filter(|outcome| outcome.is_ok()).count(), 1);
        let next = sequence + 1;
        assert!(outcomes.iter().all(|outcome| match outcome {
            Ok(stored) => stored.version == next,
            Err(RepositoryError::UnexpectedBlock { expected }) => *expected == next,
            Err(_) => false,
        }));
    }
    let (back, state, last) = store.stream_state(stream.id).await.unwrap();
    assert_eq!((back.sequence, back.node_count, back.version, back.iteration), (5, 30, 6, None));
    assert_eq!((back.input_sha256, last), ([105; 32], Some([5; 32])));
    assert_eq!(state.unwrap().data, crate::support::state(5));
    let blocks = store.blocks(stream.id, 2).await.unwrap();
    assert!(blocks.iter().map(|block| block.sequence).eq(3..=5));
    assert_eq!(store.block_sha256(stream.id, 4).await.unwrap(), Some([4; 32]));

    // nor behind other blocks than those that its estimate has seen
    let other = NewBlock { previous_sha256: [9; 32], ..NewBlock::clone(&place.block(stream.id, 6)) };
    let refused = store.insert_block(Arc::new(other), None).await;
    assert!(matches!(refused, Err(RepositoryError::UnexpectedBlock { expected: 6 })));

    // finished only as it was seen
    let finish = |sequence| FinishedStream { stream: stream.id, sequence, iteration: place.iteration(job) };
    let late = store.finish_stream(finish(4), None).await;
    assert!(matches!(late, Err(RepositoryError::UnexpectedBlock { expected: 6 })));
    assert_eq!(store.finish_stream(finish(5), None).await.unwrap().number, 1);
    let again = store.finish_stream(finish(5), None).await;
    assert!(matches!(again, Err(RepositoryError::StreamFinished { iteration: 1 })));
    let more = store.insert_block(place.block(stream.id, 6), None).await;
    assert!(matches!(more, Err(RepositoryError::StreamFinished { iteration: 1 })));
    assert!(store.blocks(stream.id, 0).await.unwrap().is_empty(), "the iteration holds the nodes");
    assert_eq!(store.stream(stream.id).await.unwrap().iteration, Some(1));

    let mut expected = vec!["open"];
    expected.extend(["block"; 5]);
    expected.extend(["iteration", "finished"]);
    assert_eq!(kinds(&events(&store, job).await), expected);
    let last = events(&store, job).await.pop().unwrap();
    let EventKind::Stream { id, state, sequence, node_count, iteration } = last.kind else {
        panic!("a stream's event")
    };
    assert_eq!((id, state, sequence, node_count, iteration), (stream.id, StreamEvent::Finished, 5, 30, Some(1)));
}

pub async fn a_job_lets_go_of_its_events_only_with_everything_else(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let stream = Arc::new(place.stream(job));
    store.insert_stream(stream.clone(), None).await.unwrap();
    store.insert_block(place.block(stream.id, 1), None).await.unwrap();
    let held = store.delete_job(job, Precondition::None).await;
    assert!(matches!(held, Err(RepositoryError::HasStreams(1))));
    let stale = store.delete_stream(stream.id, Precondition::AnyOf(vec![1]), place.now()).await;
    assert!(matches!(stale, Err(RepositoryError::VersionMismatch { current: 2 })));

    for sql in ["UPDATE events SET kind = kind", "DELETE FROM events", "DELETE FROM streams"] {
        assert!(pair.ground.refusal(sql).await.is_some(), "{sql}");
    }
    store.delete_stream(stream.id, Precondition::None, place.now()).await.unwrap();
    assert_eq!(kinds(&events(&store, job).await), ["open", "block", "deleted"]);
    assert!(matches!(store.stream(stream.id).await, Err(RepositoryError::NotFound(Resource::Stream))));
    store.delete_job(job, Precondition::None).await.unwrap();
    assert!(matches!(store.last_event(job).await, Err(RepositoryError::NotFound(Resource::Job))));
}

/// If several finish or delete a stream at the same time, one does.
pub async fn a_stream_ends_once(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let mut iterations = 0;
    for _ in 0..10 {
        let stream = Arc::new(place.stream(job));
        store.insert_stream(stream.clone(), None).await.unwrap();
        store.insert_block(place.block(stream.id, 1), None).await.unwrap();
        let finish = || {
            let iteration = place.iteration(job);
            store.finish_stream(FinishedStream { stream: stream.id, sequence: 1, iteration }, None)
        };
        let seen = || Precondition::AnyOf(vec![2]);
        let (one, two, deleted, block) = tokio::join!(
            finish(),
            finish(),
            store.delete_stream(stream.id, seen(), place.now()),
            store.insert_block(place.block(stream.id, 2), None),
        );
        let finished = u32::from(one.is_ok()) + u32::from(two.is_ok());
        let changes = finished + u32::from(deleted.is_ok()) + u32::from(block.is_ok());
        assert_eq!(changes, 1, "{one:?} {two:?} {deleted:?} {block:?}");
        iterations += finished;
        assert_eq!(
            store.trace(job, PageRequest { limit: 200, after: None }).await.unwrap().iterations.len(),
            iterations as usize
        );
        let open = store.stream(stream.id).await;
        match open {
            Ok(open) => {
                assert_eq!((open.iteration.is_some(), open.sequence), (finished == 1, 1 + u64::from(block.is_ok())))
            }
            Err(_) => assert!(deleted.is_ok()),
        }
    }
    let events = events(&store, job).await;
    let count = events.iter().filter(|event| matches!(event.kind, EventKind::Iteration { .. })).count();
    assert_eq!(count, iterations as usize);
}

pub async fn streams_are_listed_page_by_page(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let (job, other) = (place.stored_job(&store).await.id, place.stored_job(&store).await.id);
    let mut made = Vec::new();
    for _ in 0..5 {
        let stream = Arc::new(place.stream(job));
        store.insert_stream(stream.clone(), None).await.unwrap();
        made.push(stream.id);
    }
    store.insert_stream(Arc::new(place.stream(other)), None).await.unwrap();
    store.insert_block(place.block(made[1], 1), None).await.unwrap();
    let iteration = place.iteration(job);
    store.finish_stream(FinishedStream { stream: made[1], sequence: 1, iteration }, None).await.unwrap();
    store.delete_stream(made[3], Precondition::None, place.now()).await.unwrap();
    let (mut found, mut request) = (Vec::new(), PageRequest { limit: 2, after: None });
    loop {
        let page = store.streams(job, request).await.unwrap();
        found.extend(page.items);
        let Some(next) = page.next else { break };
        request.after = Some(next);
    }
    assert_eq!(found.iter().map(|stream| stream.id).collect::<Vec<_>>(), [made[0], made[1], made[2], made[4]]);
    assert!(found.iter().map(|stream| stream.iteration).eq([None, Some(1), None, None]));
    assert_eq!(found[1], store.stream(made[1]).await.unwrap());
    let strange = pair.seen_by("other").streams(job, request).await;
    assert!(matches!(strange, Err(RepositoryError::NotFound(Resource::Job))), "{strange:?}");
}
