//! Blocks of a stream, their estimates, and what is left of a stream in the end.

use std::sync::Arc;

use flankfit::jobs::{EventKind, FinishedStream, NewBlock, Precondition, RepositoryError, StreamEvent};
use flankfit_engine::estimation::Nodes;

use super::{pair::Pair, streams::events};

/// An estimate is stored now and then: the last one stays until there is a newer one.
pub async fn the_last_estimate_stays_while_blocks_come(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let stream = Arc::new(place.stream(job));
    store.insert_stream(stream.clone(), None).await.unwrap();
    let (opened, state, last) = store.stream_state(stream.id).await.unwrap();
    assert_eq!((opened.sequence, opened.version, opened.input_sha256), (0, 1, [1; 32]));
    assert_eq!((state, last), (None, None));
    assert_eq!((&opened.spec, &opened.measurand, opened.job_id), (&stream.spec, &stream.measurand, job));
    assert_eq!((opened.created_at, opened.updated_at), (stream.created_at, stream.created_at));
    for (sequence, stored) in [(1, None), (2, Some(2)), (3, Some(2)), (4, Some(4))] {
        let state = (sequence % 2 == 0).then(|| vec![sequence as u8; 3]);
        let block = Arc::new(NewBlock { state, ..NewBlock::clone(&place.block(stream.id, sequence)) });
        store.insert_block(block.clone(), None).await.unwrap();
        let (now, state, last) = store.stream_state(stream.id).await.unwrap();
        assert_eq!((now.sequence, now.version, now.node_count), (sequence, sequence + 1, 6 * sequence));
        assert_eq!((now.updated_at, last), (block.created_at, Some(block.sha256)));
        assert_eq!(state.map(|state| (state.sequence, state.data)), stored.map(|at| (at, vec![at as u8; 3])));
    }
    assert_eq!(store.block_sha256(stream.id, 3).await.unwrap(), Some([3; 32]));
    assert_eq!(store.block_sha256(stream.id, 5).await.unwrap(), None);
    assert!(store.blocks(stream.id, 4).await.unwrap().is_empty());
    assert!(store.blocks(stream.id, u64::MAX).await.unwrap().is_empty());
}

/// Large blocks come a few at a time, each once and in order.
pub async fn blocks_are_read_a_few_megabytes_at_a_time(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let stream = Arc::new(place.stream(job));
    store.insert_stream(stream.clone(), None).await.unwrap();
    let x: Vec<f64> = (0..180_000).map(f64::from).collect();
    let large = Arc::new(Nodes::curve(x.clone(), x, None).unwrap());
    for sequence in 1..=8 {
        let mut block = NewBlock::clone(&place.block(stream.id, sequence));
        if sequence != 5 {
            block.nodes = large.clone().into();
        }
        store.insert_block(Arc::new(block), None).await.unwrap();
    }
    let (mut sequences, mut reads) = (Vec::new(), 0);
    while let Some(last) = sequences.last().copied().or(Some(0)).filter(|last| *last < 8) {
        let blocks = store.blocks(stream.id, last).await.unwrap();
        assert!((1..=6).contains(&blocks.len()), "{} blocks at a time", blocks.len());
        assert!(blocks.iter().all(|block| (block.nodes.posted() == 6) == (block.sequence == 5)));
        sequences.extend(blocks.iter().map(|block| block.sequence));
        reads += 1;
    }
    assert_eq!(sequences, [1, 2, 3, 4, 5, 6, 7, 8]);
    assert!(reads >= 2);
}

/// A stream that is deleted after it was finished leaves its iteration.
pub async fn a_deleted_stream_leaves_its_iteration(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let stream = Arc::new(place.stream(job));
    store.insert_stream(stream.clone(), None).await.unwrap();
    store.insert_block(place.block(stream.id, 1), None).await.unwrap();
    let iteration = place.iteration(job);
    let finished = FinishedStream { stream: stream.id, sequence: 1, iteration: iteration.clone() };
    store.finish_stream(finished, None).await.unwrap();
    let at = place.now();
    store.delete_stream(stream.id, Precondition::AnyOf(vec![3]), at).await.unwrap();
    assert_eq!(store.iteration(job, 1).await.unwrap().id, iteration.id);
    let last = events(&store, job).await.pop().unwrap();
    let EventKind::Stream { id, state, iteration, .. } = last.kind else { panic!("{last:?}") };
    assert_eq!((id, state, iteration, last.created_at), (stream.id, StreamEvent::Deleted, Some(1), at));
    let kept = store.delete_job(job, Precondition::None).await;
    assert!(matches!(kept, Err(RepositoryError::HasIterations(1))), "{kept:?}");
}
