//! Purges remove personal and large data for good, and leave a row about it; rows, numbers and
//! chains stay, and later changes are found as before.

use std::sync::Arc;

use flankfit::jobs::{
    Answer, Caller, Choice, Decision, DecisionEvent, Event, EventKind, FinishedStream, Job, JobEvent, JobPatch,
    Measurand, NewIteration, NewRun, Precondition, Predecessors, Purge, Receipt, RecordKind, RecordSummary, Repository,
    RepositoryError, Resource, Stored, StreamEvent,
};
use jiff::SignedDuration;
use tokio::task::JoinSet;
use uuid::Uuid;

use super::pair::Pair;
use crate::support::{WHOLE, all_jobs, caller, intact, purge_of, receipt};

/// Word in every text and name that is to be removed.
const CANARY: &str = "canary";

fn event(pair: &Pair) -> Event {
    let by = Some(format!("{CANARY} actor").into());
    Event { reason: Some(format!("{CANARY} reason")), by, created_at: pair.values.now() }
}

/// A receipt whose response contains the posted text.
fn receipt_with_text(key: &str, scope: String) -> Option<Receipt> {
    let mut receipt = receipt(key, &scope);
    receipt.answer = Box::new(|_| Answer { status: 201, location: None, etag: None, body: CANARY.into() });
    Some(receipt)
}

/// An iteration of somebody, whose result is so many bytes longer than it need be.
fn iteration(pair: &Pair, job: Uuid, longer: usize) -> Arc<NewIteration> {
    let mut new = NewIteration::clone(&pair.values.iteration(job));
    new.details.operator = Some(format!("{CANARY} operator"));
    new.details.note = Some(format!("{CANARY} note"));
    new.fit.event = event(pair);
    new.fit.computed.flank = Some(format!("{{\"figures\":\"{CANARY}\"}}").into());
    new.fit.computed.spec = Arc::from(format!("{{\"spec\":\"{CANARY}\"}}"));
    let blanks = " ".repeat(longer);
    new.fit.computed.result = format!("{{\"coefficients\":[],{blanks}\"prior\":{{\"of\":\"{CANARY}\"}}}}").into();
    Arc::new(new)
}

/// A job with something of everything, by a caller with a name.
pub async fn filled(pair: &Pair) -> Uuid {
    let place = pair.values.clone();
    let named = Caller { actor: format!("{CANARY} actor").into(), ..caller("default") };
    let store = pair.handles[0].of(&named);
    let job = place.job("wheel");
    store.insert_job(job.clone(), None).await.unwrap();
    let (job, path) = (job.id, format!("POST /v1/jobs/{}", job.id));
    store
        .insert_iteration(iteration(pair, job, 0), receipt_with_text("1", format!("{path}/iterations")))
        .await
        .unwrap();
    let mut fit = place.fit(0.75);
    fit.event = event(pair);
    let fit = Arc::new(fit);
    store.insert_fit(job, 1, fit.clone(), receipt_with_text("2", format!("{path}/iterations/1/fits"))).await.unwrap();
    store.choose(job, 1, Choice { fit_id: fit.id, event: event(pair) }, Precondition::None).await.unwrap();
    let decision = DecisionEvent { decision: Decision::Remachine, concession: false, event: event(pair) };
    store.decide(job, 1, decision, Precondition::None).await.unwrap();
    let mut record = (*place.record(RecordKind::Curve, "lagrange")).clone();
    record.by = Some(format!("{CANARY} actor").into());
    record.draft.request = Arc::from(format!("{{\"request\":\"{CANARY}\"}}"));
    record.draft.result = Arc::from(format!("{{\"result\":\"{CANARY}\"}}"));
    let kept = receipt_with_text("3", format!("{path}/iterations/1/curves"));
    store.insert_record(job, 1, Arc::new(record), kept).await.unwrap();
    let streams = [(); 2].map(|()| {
        let mut stream = place.stream(job);
        stream.spec = Arc::from(format!("{{\"spec\":\"{CANARY}\"}}"));
        Arc::new(stream)
    });
    for stream in &streams {
        store
            .insert_stream(stream.clone(), receipt_with_text("4", format!("POST /v1/jobs/{job}/{}", stream.id)))
            .await
            .unwrap();
        let scope = format!("POST /v1/streams/{}/nodes", stream.id);
        store.insert_block(place.block(stream.id, 1), receipt_with_text("5", scope)).await.unwrap();
    }
    let finished = FinishedStream { stream: streams[1].id, sequence: 1, iteration: iteration(pair, job, 20_000) };
    store.finish_stream(finished, None).await.unwrap();
    job
}

/// Purges a job as it is now.
pub async fn purged(pair: &Pair, job: Uuid) -> (Arc<Purge>, Stored) {
    let purge = purge_of(&pair.values, job);
    let stored = pair.store.purge_job(purge.clone(), None).await.unwrap();
    (purge, stored)
}

#[track_caller]
fn gone<T: std::fmt::Debug>(answer: Result<T, RepositoryError>, purge: &Purge) {
    match answer {
        Err(RepositoryError::Purged { at, reason }) => {
            assert_eq!((at, &reason), (purge.at, &purge.reason));
        }
        other => panic!("{other:?}"),
    }
}

/// Events as they are returned once the reasons in them are gone.
fn without_reasons(mut events: Vec<JobEvent>) -> Vec<JobEvent> {
    for event in &mut events {
        match &mut event.kind {
            EventKind::Fit { reason, .. } | EventKind::Decision { reason, .. } => *reason = None,
            _ => {}
        }
    }
    events
}

/// After those that there were, without the reasons that were taken away.
async fn last_event_is_the_purge(store: &Arc<dyn Repository>, job: Uuid, before: Vec<JobEvent>, purge: &Purge) {
    let mut heard = store.events(job, 0, 100).await.unwrap();
    let last = heard.pop().unwrap();
    assert_eq!(heard, without_reasons(before));
    assert_eq!((last.number, last.created_at), (heard.len() as u64 + 1, purge.at));
    assert_eq!(last.kind, EventKind::Purged { reason: purge.reason.clone() });
    assert_eq!(store.last_event(job).await.unwrap(), last.number);
}

pub async fn a_purged_job_keeps_its_numbers_and_no_more(pair: &mut Pair) {
    let (store, place, none) = (pair.store.clone(), pair.values.clone(), Precondition::None);
    let job = filled(pair).await;
    let (before, listed) = (store.job(job).await.unwrap(), store.jobs(all_jobs()).await.unwrap());
    let was = store.iteration(job, 1).await.unwrap();
    let earlier = store.trace(job, WHOLE).await.unwrap();
    let fit = was.fits[0].id;
    let record = store.records(job, 1, WHOLE).await.unwrap().items[0].clone();
    let events = store.events(job, 0, 100).await.unwrap();
    let streams: Vec<Uuid> = {
        let opened = |event: &JobEvent| match event.kind {
            EventKind::Stream { id, state: StreamEvent::Open, .. } => Some(id),
            _ => None,
        };
        events.iter().filter_map(opened).collect()
    };
    assert!(pair.ground.holds(CANARY).await);

    let (purge, stored) = purged(pair, job).await;
    assert!(!pair.ground.holds(CANARY).await);
    // the row, with when it was
    let after = store.job(job).await.unwrap();
    assert_eq!(after, before.purged(purge.at));
    assert_eq!(stored.version, after.version);
    let mut all = store.jobs(all_jobs()).await.unwrap().items;
    assert_eq!(all[0].job, after);
    all[0].job = before;
    all[0].changed_at = listed.items[0].changed_at;
    assert!(all[0].figures.is_none() && listed.items[0].figures.is_some());
    all[0].figures = listed.items[0].figures.clone();
    assert_eq!(all, listed.items);
    // numbers, times and figures
    let is = store.iteration(job, 1).await.unwrap();
    assert_eq!((is.purged_at, is.version), (Some(purge.at), was.version + 1));
    assert_eq!((is.number, is.node_count, is.created_at), (1, was.node_count, was.created_at));
    assert_eq!((&is.details.operator, &is.details.note), (&None, &None));
    assert_eq!((&is.details.instrument, is.details.measured_at), (&was.details.instrument, was.details.measured_at));
    let figures = |fits: &[flankfit::jobs::FitSummary]| {
        fits.iter().map(|fit| (fit.id, fit.chosen, fit.figures.clone(), fit.event.created_at)).collect::<Vec<_>>()
    };
    assert_eq!(figures(&is.fits), figures(&was.fits));
    assert!(is.fits.iter().all(|fit| fit.event.reason.is_none()));
    assert_eq!(is.decision.as_ref().map(|d| d.decision), Some(Decision::Remachine));
    assert_eq!(store.fits(job, 1, WHOLE).await.unwrap().items, is.fits);
    assert_eq!(store.records(job, 1, WHOLE).await.unwrap().items, [RecordSummary { by: None, ..record.clone() }]);
    let traced = store.trace(job, WHOLE).await.unwrap();
    assert_eq!(traced.job.purged_at, Some(purge.at));
    assert_eq!(traced.iterations.len(), earlier.iterations.len());
    for (is, was) in traced.iterations.iter().zip(&earlier.iterations) {
        assert_eq!(
            (is.number, is.id, is.fits.len(), is.choices.len()),
            (was.number, was.id, was.fits.len(), was.choices.len())
        );
        assert!(is.fits.iter().all(|fit| fit.coefficients == "[]" && fit.prior.is_none()));
        assert!(is.choices.iter().all(|choice| choice.event.reason.is_none()));
        assert!(is.decisions.iter().all(|decision| decision.event.reason.is_none()));
    }
    last_event_is_the_purge(&store, job, events, &purge).await;

    // the rest is gone, and nothing comes to it
    gone(store.nodes(job, 1).await, &purge);
    gone(store.nodes_up_to(job, 1, 1 << 20).await, &purge);
    gone(store.nodes_up_to(job, 1, 0).await, &purge);
    gone(store.fit(job, 1, fit).await, &purge);
    gone(store.record(job, 1, record.id).await, &purge);
    gone(store.latest_record(job, 1, RecordKind::Curve).await, &purge);
    let before = Predecessors { of: Measurand::default(), from: 1, before: None, most: 10 };
    gone(store.predecessors(job, before).await, &purge);
    gone(store.rounds(job).await, &purge);
    assert_eq!(streams.len(), 2);
    for stream in streams {
        gone(store.stream(stream).await, &purge);
        gone(store.stream_state(stream).await, &purge);
        assert_eq!(store.blocks(stream, 0).await.unwrap().len(), 0);
        assert_eq!(store.block_sha256(stream, 1).await.unwrap(), None);
        gone(store.insert_block(place.block(stream, 2), None).await, &purge);
        let finished = FinishedStream { stream, sequence: 1, iteration: place.iteration(job) };
        gone(store.finish_stream(finished, None).await, &purge);
        gone(store.delete_stream(stream, none.clone(), place.now()).await, &purge);
    }
    gone(store.patch_job(job, JobPatch::default(), none.clone(), place.now()).await, &purge);
    gone(store.delete_job(job, none.clone()).await, &purge);
    gone(store.insert_iteration(place.iteration(job), None).await, &purge);
    gone(store.insert_fit(job, 1, Arc::new(place.fit(0.5)), None).await, &purge);
    gone(store.choose(job, 1, Choice { fit_id: fit, event: event(pair) }, none.clone()).await, &purge);
    let decision = DecisionEvent { decision: Decision::Accepted, concession: false, event: event(pair) };
    gone(store.decide(job, 1, decision, none.clone()).await, &purge);
    gone(store.insert_record(job, 1, place.record(RecordKind::Curve, "newton"), None).await, &purge);
    gone(store.insert_stream(Arc::new(place.stream(job)), None).await, &purge);
    // kept responses contained it
    for (key, scope) in [("1", "/iterations"), ("2", "/iterations/1/fits"), ("3", "/iterations/1/curves")] {
        assert_eq!(store.answer(key.to_owned(), format!("POST /v1/jobs/{job}{scope}")).await.unwrap(), None);
    }
    assert!(!pair.ground.holds(CANARY).await, "what was refused left nothing");
}

pub async fn a_purge_is_done_once(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = filled(pair).await;
    // another tenant's does not exist
    let other = pair.seen_by("other").purge_job(purge_of(&place, job), None).await;
    assert!(matches!(other, Err(RepositoryError::NotFound(Resource::Job))), "{other:?}");
    // its own answer is kept
    let scope = format!("POST /v1/jobs/{job}/purge");
    store.purge_job(purge_of(&place, job), Some(receipt("8", &scope))).await.unwrap();
    assert!(store.answer("8".into(), scope.clone()).await.unwrap().is_some());
    let again = store.purge_job(purge_of(&place, job), Some(receipt("8", &scope))).await;
    assert!(matches!(again, Err(RepositoryError::KeyTaken)), "{again:?}");
    let again = store.purge_job(purge_of(&place, job), None).await;
    assert!(matches!(again, Err(RepositoryError::Purged { .. })), "{again:?}");
    let nothing = store.purge_job(purge_of(&place, place.id()), None).await;
    assert!(matches!(nothing, Err(RepositoryError::NotFound(Resource::Job))), "{nothing:?}");
    intact(&pair.handles[0]).await;
}

/// A purge also removes the response to the request that stored the job together with others.
pub async fn a_purge_removes_the_answers_about_its_job_alone(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let scopes = ["POST /v1/simulations/closed-loop", "POST /v1/streams/x/nodes", "POST /v1/jobs/y/iterations"];
    let runs = [(); 2].map(|()| NewRun { job: place.job("run"), iterations: Vec::new() });
    let (now, run) = (runs[0].job.created_at, runs[1].job.id);
    let runs = runs.map(|run| NewRun { job: Job { created_at: now, updated_at: now, ..run.job }, ..run });
    store.insert_runs(runs.into(), receipt_with_text("k", scopes[0].to_owned()), now).await.unwrap();
    let stream = Arc::new(place.stream(run));
    store.insert_stream(stream.clone(), None).await.unwrap();
    store.insert_block(place.block(stream.id, 1), receipt_with_text("k", scopes[1].to_owned())).await.unwrap();
    let other = place.stored_job(&store).await.id;
    store.insert_iteration(place.iteration(other), receipt_with_text("k", scopes[2].to_owned())).await.unwrap();
    purged(pair, run).await;
    let mut kept = Vec::new();
    for scope in scopes {
        kept.push(store.answer("k".to_owned(), scope.to_owned()).await.unwrap().is_some());
    }
    assert_eq!(kept, [false, false, true]);
}

/// A response that is stored in the same transaction as the purge of its job goes with it.
pub async fn a_purge_removes_the_answers_of_its_own_transaction(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    for _ in 0..16 {
        let (job, busy) = (place.stored_job(&store).await.id, place.stored_job(&store).await.id);
        let (stream, block) = (Arc::new(place.stream(job)), Arc::new(place.stream(job)));
        store.insert_stream(block.clone(), None).await.unwrap();
        let scopes = ["streams", "nodes"].map(|end| format!("POST /v1/jobs/{job}/{end}"));
        // the first write keeps the writer busy, so that those after it make one group
        let (first, ..) = tokio::join!(
            store.insert_iteration(place.iteration(busy), None),
            store.insert_stream(stream, receipt_with_text("k", scopes[0].clone())),
            store.insert_block(place.block(block.id, 1), receipt_with_text("k", scopes[1].clone())),
            store.purge_job(purge_of(&place, job), None),
        );
        first.unwrap();
        for scope in scopes {
            assert!(store.answer("k".to_owned(), scope.clone()).await.unwrap().is_none(), "{scope}");
        }
    }
}

/// Each of many writers comes before the purge, or is refused; nothing is half done.
pub async fn a_purge_comes_before_or_after_each_writer(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    for _ in 0..4 {
        let job = place.stored_job(&store).await.id;
        let mut writers = JoinSet::new();
        for _ in 0..4 {
            let (store, place) = (store.clone(), place.clone());
            writers.spawn(async move {
                let mut stored = 0;
                loop {
                    match store.insert_iteration(place.iteration(job), None).await {
                        Ok(_) => stored += 1,
                        Err(RepositoryError::Purged { .. }) => return stored,
                        Err(other) => panic!("{other}"),
                    }
                    if stored > 25 {
                        return stored;
                    }
                    tokio::task::yield_now().await;
                }
            });
        }
        while store.last_event(job).await.unwrap() < 4 {
            tokio::task::yield_now().await;
        }
        store.purge_job(purge_of(&place, job), None).await.unwrap();
        let stored: usize = writers.join_all().await.into_iter().sum();
        let traced = store.trace(job, WHOLE).await.unwrap();
        assert_eq!(traced.iterations.len(), stored);
        for number in 1..=u32::try_from(stored).unwrap() {
            assert!(matches!(store.nodes(job, number).await, Err(RepositoryError::Purged { .. })), "{number}");
        }
    }
    intact(&pair.handles[1]).await;
}

/// One of two concurrent purges is done, the other is refused, at whichever handle.
pub async fn one_of_two_concurrent_purges_is_refused(pair: &mut Pair) {
    let place = pair.values.clone();
    for _ in 0..8 {
        let job = place.stored_job(&pair.store).await.id;
        let purges = [0, 1].map(|handle| {
            let (store, new) = (pair.handles[handle].of(&caller("default")), purge_of(&place, job));
            tokio::spawn(async move { store.purge_job(new, None).await })
        });
        let [one, two] = purges;
        let outcomes = [one.await.unwrap(), two.await.unwrap()];
        assert_eq!(outcomes.iter().filter(|outcome| outcome.is_ok()).count(), 1, "{outcomes:?}");
        let purged = |outcome: &Result<_, _>| matches!(outcome, Err(RepositoryError::Purged { .. }));
        assert_eq!(outcomes.iter().filter(|outcome| purged(outcome)).count(), 1, "{outcomes:?}");
        assert_eq!(pair.store.last_event(job).await.unwrap(), 1);
    }
}

/// Changes that triggers allow, and others.
pub async fn the_trace_loses_only_purged_columns(pair: &mut Pair) {
    let job = filled(pair).await;
    let other = filled(pair).await;
    let nothing = pair.ground.literal(&[]);
    let takes = [
        "iterations SET operator = NULL, note = NULL".to_owned(),
        "nodes SET data = data".to_owned(),
        format!("fits SET reason = NULL, spec = {nothing}, result = {nothing}"),
        "fit_choices SET reason = NULL".to_owned(),
        "decisions SET reason = NULL".to_owned(),
        format!("records SET request = {nothing}, result = {nothing}, gear = NULL"),
        "audit SET actor = NULL, salt = NULL".to_owned(),
    ];
    let takes = takes.map(|sql| &*format!("UPDATE {sql}").leak());
    let refused = async |pair: &Pair, sql: &'static str| {
        let refusal = pair.ground.refusal(sql).await;
        assert!(refusal.as_deref().is_some_and(|why| why.contains("append-only")), "{sql}: {refusal:?}");
    };
    for sql in takes {
        refused(pair, sql).await;
    }
    purged(pair, job).await;
    // there is also a job that was not purged
    for sql in takes {
        refused(pair, sql).await;
    }
    assert!(pair.ground.holds(CANARY).await, "the other job's");
    purged(pair, other).await;
    for sql in [
        "UPDATE iterations SET instrument = NULL",
        "UPDATE iterations SET operator = 'x'",
        "UPDATE nodes SET count = 0",
        "UPDATE fits SET rms = NULL",
        "UPDATE fits SET lambda_star = -lambda_star",
        "UPDATE fits SET result = (SELECT who FROM audit LIMIT 1)",
        "UPDATE fit_choices SET position = position + 10",
        "UPDATE decisions SET decision = 'accepted'",
        "UPDATE records SET method = 'x'",
        "UPDATE audit SET actor = 'x'",
        "UPDATE audit SET actor = NULL, salt = NULL, subject = ''",
        "UPDATE audit SET actor = NULL, salt = NULL, contents = who",
        "UPDATE purges SET reason = ''",
        "DELETE FROM purges",
        "DELETE FROM nodes",
        "DELETE FROM fits",
        "DELETE FROM audit",
    ] {
        refused(pair, sql).await;
    }
    assert!(pair.ground.refusal("DELETE FROM jobs").await.is_some());
}

/// Jobs that are due, of every tenant.
pub async fn inactive_jobs_are_due(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let first = place.stored_job(&store).await.id;
    let other = place.stored_job(&pair.seen_by("other")).await.id;
    let streaming = place.stored_job(&store).await.id;
    let stream = Arc::new(place.stream(streaming));
    store.insert_stream(stream.clone(), None).await.unwrap();
    let since = place.now();
    let due = async |handle: usize| {
        let (mut due, mut after) = (Vec::new(), None);
        loop {
            let some = pair.handles[handle].untouched(since, after, 1).await.unwrap();
            after = some.last().cloned();
            due.extend(some.into_iter().map(|key| (key.tenant.as_str().to_owned(), key.job)));
            if after.is_none() {
                return due;
            }
        }
    };
    let of = |tenant: &str, job: Uuid| (tenant.to_owned(), job);
    assert_eq!(due(0).await, [of("default", first), of("default", streaming), of("other", other)]);
    assert_eq!(pair.handles[0].untouched(since - SignedDuration::from_hours(1), None, 10).await.unwrap(), []);
    // a block touches its job, and so does an iteration; a purged one is not due again
    store.insert_block(place.block(stream.id, 1), None).await.unwrap();
    assert_eq!(due(1).await, [of("default", first), of("other", other)]);
    purged(pair, first).await;
    assert_eq!(due(0).await, [of("other", other)]);
    place.stored_iteration(&pair.seen_by("other"), other).await;
    assert_eq!(due(1).await, []);
}
