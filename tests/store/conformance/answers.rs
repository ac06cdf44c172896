//! Responses kept under idempotency keys: stored once, and returned again as they were first.

use std::sync::Arc;

use flankfit::jobs::{
    Answer, Choice, Decision, DecisionEvent, Event, FinishedStream, NewFit, NewRun, Precondition, Receipt, RecordKind,
    RepositoryError, Resource, RunningKeys, Stored, Tenant,
};
use tokio::task::JoinSet;

use super::pair::Pair;
use crate::support::{WHOLE, actor, all_jobs, receipt};

pub async fn a_key_stores_once_and_its_answer_outlives_the_store(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let (job, scope) = (place.stored_job(&store).await.id, "POST /v1/jobs/1/iterations");
    let mut tasks = JoinSet::new();
    for _ in 0..20 {
        let (place, store) = (place.clone(), store.clone());
        tasks.spawn(async move { store.insert_iteration(place.iteration(job), Some(receipt("once", scope))).await });
    }
    let outcomes = tasks.join_all().await;
    assert_eq!(outcomes.iter().filter(|outcome| outcome.is_ok()).count(), 1);
    assert!(outcomes.iter().all(|outcome| matches!(outcome, Ok(_) | Err(RepositoryError::KeyTaken))));

    pair.reopen().await;
    let store = pair.store.clone();
    let (digest, answer) = store.answer("once".into(), scope.into()).await.unwrap().unwrap();
    assert_eq!((digest, answer.status, answer.location.as_deref()), ([7; 32], 201, Some("/there")));
    assert_eq!((answer.etag.as_deref(), answer.body.as_slice()), (Some("\"1\""), br#"{"number":1}"#.as_slice()));
    assert_eq!(store.answer("once".into(), "POST /elsewhere".into()).await.unwrap(), None);
    assert_eq!(store.answer("twice".into(), scope.into()).await.unwrap(), None);
    assert_eq!(store.trace(job, WHOLE).await.unwrap().iterations.len(), 1);
    let late = store.insert_iteration(place.iteration(job), Some(receipt("once", scope))).await;
    assert!(matches!(late, Err(RepositoryError::KeyTaken)));
}

/// A response with the result of a fit in it, like those of iterations and fits.
fn receipt_with_result(key: &str, fit: &NewFit) -> (Receipt, impl Fn(Stored) -> Answer + Clone + 'static) {
    let result = fit.computed.result.text().clone();
    let answer = move |stored: Stored| Answer {
        status: 201,
        location: None,
        etag: Some(stored.version.to_string()),
        body: format!(r#"{{"number":{},"fits":[{{"chosen":true,"result":{result}}}]}}"#, stored.number).into_bytes(),
    };
    let copy = answer.clone();
    (Receipt { answer: Box::new(copy), ..receipt(key, "POST /there") }, answer)
}

/// Whatever was fitted, chosen and decided since.
pub async fn the_first_answer_comes_again_byte_for_byte(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let mut given = Vec::new();

    let iteration = place.iteration(job);
    let (keyed, answer) = receipt_with_result("iteration", &iteration.fit);
    given.push(("iteration", answer(store.insert_iteration(iteration.clone(), Some(keyed)).await.unwrap())));

    let fit = Arc::new(place.fit(0.25));
    let (keyed, answer) = receipt_with_result("fit", &fit);
    given.push(("fit", answer(store.insert_fit(job, 1, fit.clone(), Some(keyed)).await.unwrap())));

    let stream = Arc::new(place.stream(job));
    store.insert_stream(stream.clone(), None).await.unwrap();
    store.insert_block(place.block(stream.id, 1), None).await.unwrap();
    let finished = FinishedStream { stream: stream.id, sequence: 1, iteration: place.iteration(job) };
    let (keyed, answer) = receipt_with_result("finish", &finished.iteration.fit);
    given.push(("finish", answer(store.finish_stream(finished, Some(keyed)).await.unwrap())));

    // an answer that does not have the result in it is kept as it is
    let bare = place.iteration(job);
    let (keyed, answer) = receipt_with_result("bare", &place.fit(0.5));
    given.push(("bare", answer(store.insert_iteration(bare, Some(keyed)).await.unwrap())));

    let event = || Event { reason: Some("smoother".to_owned()), by: actor(), created_at: place.now() };
    store.insert_fit(job, 1, Arc::new(place.fit(0.75)), None).await.unwrap();
    store.choose(job, 1, Choice { fit_id: fit.id, event: event() }, Precondition::None).await.unwrap();
    let decision = DecisionEvent { decision: Decision::Accepted, concession: false, event: event() };
    store.decide(job, 2, decision, Precondition::None).await.unwrap();
    pair.reopen().await;
    for (key, answer) in given {
        let (_, again) = pair.store.answer(key.to_owned(), "POST /there".to_owned()).await.unwrap().unwrap();
        assert_eq!(again, answer, "{key}");
    }
}

/// Each write that takes a key: with one that has an answer it stores nothing.
pub async fn a_taken_key_stores_nothing(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    place.stored_iteration(&store, job).await;
    let stream = Arc::new(place.stream(job));
    store.insert_stream(stream.clone(), None).await.unwrap();
    store.insert_block(place.block(stream.id, 1), None).await.unwrap();
    store.insert_job(place.job("first"), Some(receipt("k", "POST /there"))).await.unwrap();
    let before = (
        store.jobs(all_jobs()).await.unwrap(),
        store.trace(job, WHOLE).await.unwrap(),
        store.events(job, 0, 1000).await.unwrap(),
        store.stream(stream.id).await.unwrap(),
    );
    let keyed = || Some(receipt("k", "POST /there"));
    let finished = FinishedStream { stream: stream.id, sequence: 1, iteration: place.iteration(job) };
    let run = NewRun { job: place.job("run"), iterations: Vec::new() };
    for (write, outcome) in [
        ("job", store.insert_job(place.job("second"), keyed()).await),
        ("runs", store.insert_runs(vec![run], keyed(), place.now()).await),
        ("iteration", store.insert_iteration(place.iteration(job), keyed()).await),
        ("fit", store.insert_fit(job, 1, Arc::new(place.fit(0.5)), keyed()).await),
        ("record", store.insert_record(job, 1, place.record(RecordKind::Curve, "newton"), keyed()).await),
        ("stream", store.insert_stream(Arc::new(place.stream(job)), keyed()).await),
        ("block", store.insert_block(place.block(stream.id, 2), keyed()).await),
        ("finish", store.finish_stream(finished, keyed()).await),
    ] {
        assert!(matches!(outcome, Err(RepositoryError::KeyTaken)), "{write}: {outcome:?}");
    }
    let after = (
        store.jobs(all_jobs()).await.unwrap(),
        store.trace(job, WHOLE).await.unwrap(),
        store.events(job, 0, 1000).await.unwrap(),
        store.stream(stream.id).await.unwrap(),
    );
    assert_eq!(after, before);
}

pub async fn a_refused_request_leaves_its_key_free(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let keyed = || Some(receipt("k", "POST /there"));
    let refused = store.insert_iteration(place.iteration(place.id()), keyed()).await;
    assert!(matches!(refused, Err(RepositoryError::NotFound(Resource::Job))));
    let refused = store.insert_fit(job, 1, Arc::new(place.fit(0.5)), keyed()).await;
    assert!(matches!(refused, Err(RepositoryError::NotFound(Resource::Iteration))));
    assert_eq!(store.answer("k".to_owned(), "POST /there".to_owned()).await.unwrap(), None);
    assert_eq!(store.insert_iteration(place.iteration(job), keyed()).await.unwrap().number, 1);
}

/// A client that has the outcome may repeat its request at once: the key that was claimed for it is
/// released before.
pub async fn a_claimed_key_is_given_back_with_the_outcome(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let (keys, tenant) = (RunningKeys::default(), Tenant::default());
    for of in [job, place.id(), job] {
        let claim = keys.claim(&tenant, "k", "POST /there").expect("the key is free");
        let mut keyed = receipt("k", "POST /there");
        keyed.request.claim = Some(Arc::new(claim));
        let _stored_or_refused = store.insert_iteration(place.iteration(of), Some(keyed)).await;
    }
    assert!(keys.claim(&tenant, "k", "POST /there").is_some());
}
