//! What comes back is what went in, and the trace tells everything in order.

use std::sync::Arc;

use flankfit::jobs::{
    Choice, Cursor, Decision, DecisionEvent, Earlier, Event, JobPatch, MAX_LISTED, PageRequest, Precondition,
    RepositoryError, Resource, Update,
};
use uuid::Uuid;

use super::pair::Pair;
use crate::support::{Values, WHOLE, nodes};

pub async fn a_job_comes_back_and_counts_its_changes(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    assert_eq!(store.job(job.id).await.unwrap(), job);

    let patch = JobPatch { machine: Update::Set("K300".into()), gear: Update::Clear, ..JobPatch::default() };
    let seen = Precondition::AnyOf(vec![1]);
    let patched = store.patch_job(job.id, patch.clone(), seen.clone(), place.now()).await.unwrap();
    assert_eq!((patched.version, patched.machine.as_deref(), patched.gear.as_deref()), (2, Some("K300"), None));
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
    second.reason = Some("more shrinkage".into());
    let second = Arc::new(second);
    let stored = store.insert_fit(job.id, 1, second.clone(), None).await.unwrap();
    assert_eq!((stored.number, stored.version), (1, 2));

    let event = |reason: &str| Event { reason: Some(reason.to_owned()), created_at: place.now() };
    let none = Precondition::None;
    let choose = |fit_id, reason| store.choose(job.id, 1, Choice { fit_id, event: event(reason) }, Precondition::None);
    assert_eq!(choose(second.id, "smoother").await.unwrap().version, 3);
    assert_eq!(choose(second.id, "smoother").await.unwrap().version, 3, "saying the same again is no new choice");
    assert_eq!(choose(first.fit.id, "back").await.unwrap().version, 4);
    assert!(matches!(choose(job.id, "no fit").await, Err(RepositoryError::ForeignFit(id)) if id == job.id));
    let rule =
        |decision, reason| store.decide(job.id, 1, DecisionEvent { decision, event: event(reason) }, none.clone());
    assert_eq!(rule(Decision::Remachine, "slope").await.unwrap().version, 5);
    assert_eq!(rule(Decision::Accept, "measured again").await.unwrap().version, 6);
    let late = DecisionEvent { decision: Decision::Reject, event: event("late") };
    let late = store.decide(job.id, 1, late, Precondition::AnyOf(vec![5])).await;
    assert!(matches!(late, Err(RepositoryError::VersionMismatch { current: 6 })));

    let trace = store.trace(job.id, WHOLE).await.unwrap();
    assert_eq!(trace.job, job);
    let told = &trace.iterations[0];
    let fits: Vec<_> =
        told.fits.iter().map(|fit| &fit.summary).map(|fit| (fit.id, fit.chosen, fit.figures.lambda_star)).collect();
    assert_eq!(fits, [(first.fit.id, true, Some(1e-4)), (second.id, false, Some(0.25))]);
    assert_eq!(told.fits[1].summary.figures, second.computed.figures);
    assert_eq!(told.fits[1].coefficients, r#"[{"term":"1","value":0.25}]"#);
    assert_eq!(told.fits[1].summary.event.reason.as_deref(), Some("more shrinkage"));
    let choices: Vec<_> = told.choices.iter().map(|choice| (choice.fit_id, choice.event.reason.as_deref())).collect();
    assert_eq!(choices, [(first.fit.id, None), (second.id, Some("smoother")), (first.fit.id, Some("back"))]);
    let decisions: Vec<_> = told.decisions.iter().map(|decision| decision.decision).collect();
    assert_eq!(decisions, [Decision::Remachine, Decision::Accept]);
    let fits = store.iteration(job.id, 1).await.unwrap().fits;
    assert_eq!(fits.iter().map(|fit| fit.chosen).collect::<Vec<_>>(), [true, false]);
    assert!(!store.fit(job.id, 1, second.id).await.unwrap().chosen);
    assert_eq!(store.iteration(job.id, 1).await.unwrap().decision.unwrap().decision, Decision::Accept);
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
        let event = Event { reason: Some(k.to_string()), created_at: place.now() };
        store.choose(job.id, 2, Choice { fit_id: fit.id, event: event.clone() }, Precondition::None).await.unwrap();
        store.decide(job.id, 2, DecisionEvent { decision: Decision::Accept, event }, Precondition::None).await.unwrap();
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
    // the last ones are told, in order, and the others counted
    let most = MAX_LISTED as usize;
    let iteration = store.iteration(job.id, 2).await.unwrap();
    assert_eq!(iteration.fits.iter().map(|fit| fit.id).collect::<Vec<_>>(), ids[ids.len() - most..]);
    assert_eq!((iteration.earlier_fits, iteration.fits[most - 1].chosen), (5, true));
    let told = &store.trace(job.id, WHOLE).await.unwrap().iterations[1];
    assert_eq!((told.fits.len(), told.choices.len(), told.decisions.len()), (most, most, most));
    assert_eq!(told.earlier, Earlier { fits: 5, choices: 5, decisions: 4, records: 0 });
    assert_eq!(told.choices[most - 1].fit_id, ids[ids.len() - 1]);
}

/// However long the answers of fits are, a page of the trace is not.
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
    let told: Vec<(usize, u64)> = page.iterations.iter().map(|it| (it.fits.len(), it.earlier.fits)).collect();
    // 3 MiB, then at least one fit of the next iteration, with which the page is full
    assert_eq!(told, [(2, 0), (1, 2)]);
    assert_eq!(page.iterations[0].fits[1].coefficients, long(&place).1, "as it was answered");
    let rest = store.trace(job.id, PageRequest { limit: 50, after: page.next }).await.unwrap();
    assert_eq!(rest.iterations.iter().map(|it| (it.fits.len(), it.earlier.fits)).collect::<Vec<_>>(), [(1, 3)]);
    assert_eq!(rest.next, None);
}
