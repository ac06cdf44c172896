//! Rows are read as they were written, and the trace has everything in order.

use std::sync::Arc;

use flankfit::jobs::{
    Choice, Cursor, Decision, DecisionEvent, Earlier, Event, FitSummary, Job, JobPatch, JobStatus, ListedIteration,
    MAX_LISTED, NewIteration, PageRequest, Precondition, Record, RecordKind, RecordSummary, RepositoryError, Resource,
    Update,
};
use uuid::Uuid;

use super::pair::Pair;
use crate::support::{Values, WHOLE, actor, nodes};

pub async fn a_job_comes_back_and_counts_its_changes(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    assert_eq!(store.job(job.id).await.unwrap(), job);

    let required: Arc<str> = r#"{"tolerance_limits":{"class":7}}"#.into();
    let requirements = Update::Set(required.clone());
    let patch =
        JobPatch { machine: Update::Set("K300".into()), gear: Update::Clear, requirements, ..JobPatch::default() };
    let seen = Precondition::AnyOf(vec![1]);
    let patched = store.patch_job(job.id, patch.clone(), seen.clone(), place.now()).await.unwrap();
    assert_eq!((patched.version, patched.machine.as_deref(), patched.gear.as_deref()), (2, Some("K300"), None));
    assert_eq!(patched.requirements, Some(required));
    assert_eq!(store.job(job.id).await.unwrap(), patched);

    let late = store.patch_job(job.id, patch, seen, place.now()).await;
    assert!(matches!(late, Err(RepositoryError::VersionMismatch { current: 2 })));
    assert!(matches!(store.job(Uuid::nil()).await, Err(RepositoryError::NotFound(Resource::Job))));
}

pub async fn only_an_empty_job_is_deleted(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let (empty, full) = (place.stored_job(&store).await, place.stored_job(&store).await);
    place.stored_iteration(&store, full.id).await;
    store.delete_job(empty.id, Precondition::None).await.unwrap();
    assert!(matches!(store.job(empty.id).await, Err(RepositoryError::NotFound(Resource::Job))));
    let refused = store.delete_job(full.id, Precondition::None).await;
    assert!(matches!(refused, Err(RepositoryError::HasIterations(1))));
    assert_eq!(store.trace(full.id, WHOLE).await.unwrap().iterations.len(), 1);
}

pub async fn an_iteration_comes_back_bit_for_bit(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    let (new, stored) = place.stored_iteration(&store, job.id).await;
    assert_eq!((stored.number, stored.version), (1, 1));
    let back = store.iteration(job.id, 1).await.unwrap();
    assert_eq!((back.id, back.job_id, back.number, back.version), (new.id, job.id, 1, 1));
    assert_eq!(back.measurand, new.measurand);
    assert_eq!(store.measurand(job.id, 1).await.unwrap(), new.measurand);
    assert_eq!((&back.details, back.created_at), (&new.details, new.created_at));
    assert_eq!((back.node_count, back.fits[0].id, back.decision), (6, new.fit.id, None));
    assert_eq!(back.fits.len(), 1);
    assert_eq!((back.fits[0].chosen, &back.fits[0].figures), (true, &new.fit.computed.figures));
    let fit = store.fit(job.id, 1, new.fit.id).await.unwrap();
    assert_eq!((&fit.result, &fit.spec, fit.chosen), (new.fit.computed.result.text(), &new.fit.computed.spec, true));
    assert_eq!((&fit.flank, &back.fits[0].flank), (&new.fit.computed.flank, &new.fit.computed.flank));
    // NaN differs from itself; what is printed does not.
    assert_eq!(format!("{:?}", store.nodes(job.id, 1).await.unwrap()), format!("{:?}", nodes()));

    assert!(matches!(store.iteration(job.id, 2).await, Err(RepositoryError::NotFound(Resource::Iteration))));
    assert!(matches!(store.iteration(Uuid::nil(), 1).await, Err(RepositoryError::NotFound(Resource::Job))));
    assert!(matches!(store.nodes(job.id, 2).await, Err(RepositoryError::NotFound(Resource::Iteration))));
    assert!(matches!(store.fit(job.id, 1, Uuid::nil()).await, Err(RepositoryError::NotFound(Resource::Fit))));
    assert!(matches!(store.trace(Uuid::nil(), WHOLE).await, Err(RepositoryError::NotFound(Resource::Job))));
}

pub async fn the_trace_keeps_every_choice_and_ruling_in_order(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    let (first, _) = place.stored_iteration(&store, job.id).await;
    let mut second = place.fit(0.25);
    second.event.reason = Some("more shrinkage".into());
    let second = Arc::new(second);
    let stored = store.insert_fit(job.id, 1, second.clone(), None).await.unwrap();
    assert_eq!((stored.number, stored.version), (1, 2));

    let event = |reason: &str| Event { reason: Some(reason.to_owned()), by: actor(), created_at: place.now() };
    let none = Precondition::None;
    let choose = |fit_id, reason| store.choose(job.id, 1, Choice { fit_id, event: event(reason) }, Precondition::None);
    assert_eq!(choose(second.id, "smoother").await.unwrap().version, 3);
    assert_eq!(choose(second.id, "smoother").await.unwrap().version, 3, "saying the same again is no new choice");
    assert_eq!(choose(first.fit.id, "back").await.unwrap().version, 4);
    assert!(matches!(choose(job.id, "no fit").await, Err(RepositoryError::ForeignFit(id)) if id == job.id));
    let rule = |decision, reason| {
        store.decide(job.id, 1, DecisionEvent { decision, concession: false, event: event(reason) }, none.clone())
    };
    assert_eq!(rule(Decision::Remachine, "slope").await.unwrap().version, 5);
    assert_eq!(rule(Decision::Accepted, "measured again").await.unwrap().version, 6);
    let late = DecisionEvent { decision: Decision::Rejected, concession: false, event: event("late") };
    let late = store.decide(job.id, 1, late, Precondition::AnyOf(vec![5])).await;
    assert!(matches!(late, Err(RepositoryError::VersionMismatch { current: 6 })));

    let trace = store.trace(job.id, WHOLE).await.unwrap();
    assert_eq!(trace.job, Job { status: JobStatus::Accepted, ..job });
    let traced = &trace.iterations[0];
    let fits: Vec<_> =
        traced.fits.iter().map(|fit| &fit.summary).map(|fit| (fit.id, fit.chosen, fit.figures.lambda_star)).collect();
    assert_eq!(fits, [(first.fit.id, true, Some(1e-4)), (second.id, false, Some(0.25))]);
    assert_eq!(traced.fits[1].summary.figures, second.computed.figures);
    assert_eq!(traced.fits[1].coefficients, r#"[{"term":"1","value":0.25}]"#);
    assert_eq!(traced.fits[1].summary.event.reason.as_deref(), Some("more shrinkage"));
    let choices: Vec<_> = traced.choices.iter().map(|choice| (choice.fit_id, choice.event.reason.as_deref())).collect();
    assert_eq!(choices, [(first.fit.id, None), (second.id, Some("smoother")), (first.fit.id, Some("back"))]);
    assert_eq!((&traced.instrument, &traced.operator), (&Some("CMM".to_owned()), &Some("Ida".to_owned())));
    let decisions: Vec<_> = traced.decisions.iter().map(|decision| decision.decision).collect();
    assert_eq!(decisions, [Decision::Remachine, Decision::Accepted]);
    let fits = store.iteration(job.id, 1).await.unwrap().fits;
    assert_eq!(fits.iter().map(|fit| fit.chosen).collect::<Vec<_>>(), [true, false]);
    assert!(!store.fit(job.id, 1, second.id).await.unwrap().chosen);
    assert_eq!(store.iteration(job.id, 1).await.unwrap().decision.unwrap().decision, Decision::Accepted);
}

/// Each iteration is listed with its chosen fit and the last decision.
pub async fn iterations_are_listed_with_fit_and_decision(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    assert_eq!(store.iterations(job.id, WHOLE).await.unwrap().items, []);
    let mut expected = Vec::new();
    for number in 1..=7_u32 {
        let mut new = NewIteration::clone(&place.iteration(job.id));
        if number == 3 {
            (new.measurand, new.fit.computed.flank) = (Default::default(), None);
        }
        store.insert_iteration(Arc::new(new.clone()), None).await.unwrap();
        expected.push(ListedIteration {
            id: new.id,
            number,
            measurand: new.measurand.clone(),
            measured_at: new.details.measured_at,
            instrument: new.details.instrument.clone(),
            operator: new.details.operator.clone(),
            created_at: new.created_at,
            decision: None,
            decided_by: None,
            fit: FitSummary {
                id: new.fit.id,
                chosen: true,
                chosen_by: actor(),
                figures: new.fit.computed.figures.clone(),
                flank: new.fit.computed.flank.clone(),
                event: new.fit.event.clone(),
            },
        });
    }
    let other = place.fit(0.25);
    store.insert_fit(job.id, 2, Arc::new(other.clone()), None).await.unwrap();
    store.insert_fit(job.id, 2, Arc::new(place.fit(0.75)), None).await.unwrap();
    let event = |by: &str| Event { reason: None, by: Some(by.into()), created_at: place.now() };
    let choice = Choice { fit_id: other.id, event: event("key-c") };
    store.choose(job.id, 2, choice, Precondition::None).await.unwrap();
    for (decision, by) in [(Decision::Remachine, "key-a"), (Decision::Accepted, "key-b")] {
        store
            .decide(job.id, 4, DecisionEvent { decision, concession: false, event: event(by) }, Precondition::None)
            .await
            .unwrap();
    }
    let second = &mut expected[1].fit;
    (second.id, second.event, second.figures) = (other.id, other.event, other.computed.figures);
    (second.chosen_by, second.flank) = (Some("key-c".into()), other.computed.flank);
    (expected[3].decision, expected[3].decided_by) = (Some(Decision::Accepted), Some("key-b".into()));
    let (mut found, mut after) = (Vec::new(), None);
    loop {
        let page = store.iterations(job.id, PageRequest { limit: 3, after }).await.unwrap();
        assert!(page.items.len() <= 3);
        found.extend(page.items);
        after = page.next;
        if after.is_none() {
            break;
        }
    }
    assert_eq!(found, expected);
    assert!(matches!(store.iterations(Uuid::nil(), WHOLE).await, Err(RepositoryError::NotFound(Resource::Job))));
}

/// Each says of its own who did it, and nobody where nobody was known.
pub async fn actors_are_stored_with_their_changes(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    let event = |by: Option<&str>| Event { reason: None, by: by.map(Into::into), created_at: place.now() };
    let mut new = NewIteration::clone(&place.iteration(job.id));
    new.fit.event = event(Some("key-a"));
    new.records =
        vec![Record { by: Some("key-a".into()), ..Record::clone(&place.record(RecordKind::Curve, "hermite")) }];
    store.insert_iteration(Arc::new(new.clone()), None).await.unwrap();
    let mut refit = place.fit(0.25);
    refit.event = event(Some("key-b"));
    store.insert_fit(job.id, 1, Arc::new(refit.clone()), None).await.unwrap();
    let mut nobodys = place.fit(0.5);
    nobodys.event = event(None);
    store.insert_fit(job.id, 1, Arc::new(nobodys.clone()), None).await.unwrap();
    let record = Record { by: None, ..Record::clone(&place.record(RecordKind::Curve, "lagrange")) };
    store.insert_record(job.id, 1, Arc::new(record.clone()), None).await.unwrap();

    let found = store.iteration(job.id, 1).await.unwrap();
    let authors = |fits: &[FitSummary]| -> Vec<[Option<Arc<str>>; 2]> {
        fits.iter().map(|fit| [fit.event.by.clone(), fit.chosen_by.clone()]).collect()
    };
    let key = |name: &str| Some(Arc::from(name));
    assert_eq!(authors(&found.fits), [[key("key-a"), key("key-a")], [key("key-b"), None], [None, None]]);
    for by in [Some("key-c"), None] {
        let choice = Choice { fit_id: if by.is_some() { refit.id } else { nobodys.id }, event: event(by) };
        store.choose(job.id, 1, choice, Precondition::None).await.unwrap();
        let decision = if by.is_some() { Decision::Remachine } else { Decision::Accepted };
        store
            .decide(job.id, 1, DecisionEvent { decision, concession: false, event: event(by) }, Precondition::None)
            .await
            .unwrap();
        let found = store.iteration(job.id, 1).await.unwrap();
        assert_eq!(found.decision.unwrap().event.by.as_deref(), by);
        let expected = [None, by.and_then(key), None];
        assert_eq!(found.fits.iter().map(|fit| fit.chosen_by.clone()).collect::<Vec<_>>(), expected);
    }
    let page = store.fits(job.id, 1, WHOLE).await.unwrap();
    assert_eq!(authors(&page.items), [[key("key-a"), None], [key("key-b"), None], [None, None]]);
    assert_eq!(store.fit(job.id, 1, refit.id).await.unwrap().event, refit.event);
    assert_eq!(store.fit(job.id, 1, nobodys.id).await.unwrap().event.by, None);
    assert_eq!(store.record(job.id, 1, record.id).await.unwrap(), record);
    assert_eq!(store.record(job.id, 1, new.records[0].id).await.unwrap(), new.records[0]);
    let by = |found: Vec<RecordSummary>| found.into_iter().map(|record| record.by).collect::<Vec<_>>();
    assert_eq!(by(store.records(job.id, 1, WHOLE).await.unwrap().items), [key("key-a"), None]);

    let traced = store.trace(job.id, WHOLE).await.unwrap().iterations.remove(0);
    let summaries: Vec<FitSummary> = traced.fits.into_iter().map(|fit| fit.summary).collect();
    assert_eq!(authors(&summaries), authors(&page.items));
    let choices: Vec<_> = traced.choices.into_iter().map(|choice| choice.event.by).collect();
    assert_eq!(choices, [key("key-a"), key("key-c"), None]);
    let decisions: Vec<_> = traced.decisions.into_iter().map(|decision| decision.event.by).collect();
    assert_eq!(decisions, [key("key-c"), None]);
    assert_eq!(by(traced.records), [key("key-a"), None]);
}

/// A job with many iterations and an iteration with many fits are read page by page.
pub async fn the_trace_and_the_fits_come_in_pages(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    for _ in 0..7 {
        place.stored_iteration(&store, job.id).await;
    }
    let (mut numbers, mut after) = (Vec::new(), None);
    loop {
        let page = store.trace(job.id, PageRequest { limit: 3, after }).await.unwrap();
        assert!((1..=3).contains(&page.iterations.len()));
        numbers.extend(page.iterations.iter().map(|iteration| iteration.number));
        after = page.next;
        if after.is_none() {
            break;
        }
    }
    assert_eq!(numbers, [1, 2, 3, 4, 5, 6, 7]);
    let beyond = PageRequest { limit: 3, after: Some(Cursor(Uuid::max())) };
    assert_eq!(store.trace(job.id, beyond).await.unwrap().iterations, []);

    let mut ids = vec![store.iteration(job.id, 2).await.unwrap().fits[0].id];
    for k in 0..MAX_LISTED + 4 {
        let fit = Arc::new(place.fit(f64::from(k)));
        store.insert_fit(job.id, 2, fit.clone(), None).await.unwrap();
        ids.push(fit.id);
        let event = Event { reason: Some(k.to_string()), by: actor(), created_at: place.now() };
        store.choose(job.id, 2, Choice { fit_id: fit.id, event: event.clone() }, Precondition::None).await.unwrap();
        store
            .decide(
                job.id,
                2,
                DecisionEvent { decision: Decision::Accepted, concession: false, event },
                Precondition::None,
            )
            .await
            .unwrap();
    }
    let (mut found, mut after) = (Vec::new(), None);
    loop {
        let page = store.fits(job.id, 2, PageRequest { limit: 40, after }).await.unwrap();
        found.extend(page.items.iter().map(|fit| fit.id));
        after = page.next;
        if after.is_none() {
            break;
        }
    }
    assert_eq!(found, ids);
    // the last ones are listed, in order, and the others counted
    let most = MAX_LISTED as usize;
    let iteration = store.iteration(job.id, 2).await.unwrap();
    assert_eq!(iteration.fits.iter().map(|fit| fit.id).collect::<Vec<_>>(), ids[ids.len() - most..]);
    assert_eq!((iteration.earlier_fits, iteration.fits[most - 1].chosen), (5, true));
    let traced = &store.trace(job.id, WHOLE).await.unwrap().iterations[1];
    assert_eq!((traced.fits.len(), traced.choices.len(), traced.decisions.len()), (most, most, most));
    assert_eq!(traced.earlier, Earlier { fits: 5, choices: 5, decisions: 4, records: 0 });
    assert_eq!(traced.choices[most - 1].fit_id, ids[ids.len() - 1]);
}

/// A page of the trace is bounded, however long the responses of fits are.
pub async fn a_page_of_the_trace_is_bounded_in_bytes_too(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    let long = |place: &Values| {
        let mut fit = place.fit(0.5);
        let coefficients = format!(r#"[{{"term":"{}","value":1.50}}]"#, "u".repeat(3 << 20));
        fit.computed.result = format!(r#"{{"coefficients":{coefficients},"residuals":{{"values":[1,2]}}}}"#).into();
        (Arc::new(fit), coefficients)
    };
    for number in 1..=3 {
        place.stored_iteration(&store, job.id).await;
        for _ in 0..number {
            store.insert_fit(job.id, number, long(&place).0, None).await.unwrap();
        }
    }
    let page = store.trace(job.id, WHOLE).await.unwrap();
    let counts: Vec<(usize, u64)> = page.iterations.iter().map(|it| (it.fits.len(), it.earlier.fits)).collect();
    // 3 MiB, then at least one fit of the next iteration, with which the page is full
    assert_eq!(counts, [(2, 0), (1, 2)]);
    assert_eq!(page.iterations[0].fits[1].coefficients, long(&place).1, "as it was answered");
    let rest = store.trace(job.id, PageRequest { limit: 50, after: page.next }).await.unwrap();
    assert_eq!(rest.iterations.iter().map(|it| (it.fits.len(), it.earlier.fits)).collect::<Vec<_>>(), [(1, 3)]);
    assert_eq!(rest.next, None);
}
