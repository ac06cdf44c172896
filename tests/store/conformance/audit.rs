//! Each change leaves one entry, linked to the one before it; what changes nothing leaves none.

use std::{collections::BTreeSet, sync::Arc};

use flankfit::jobs::{
    Choice, Decision, DecisionEvent, Event, FinishedStream, JobPatch, NewRun, Precondition, RecordKind, Repository,
    RepositoryError,
    audit::{Chain, Contents, Entry, Head},
};
use sha2::{Digest as _, Sha256};
use tokio::task::JoinSet;
use uuid::Uuid;

use super::pair::Pair;
use crate::support::{Values, WHOLE, actor, caller, receipt};

/// The entries of a job, each checked against its digest and the one before it.
pub async fn entries(store: &Arc<dyn Repository>, job: Uuid) -> Vec<Entry> {
    let entries = store.audit(Chain::Job(job), WHOLE).await.unwrap().items;
    let mut head = Head::before(Chain::Job(job), &caller("default").tenant);
    for entry in &entries {
        assert_eq!((entry.number, entry.previous, entry.sha256), (head.number + 1, head.sha256, entry.digest()));
        assert_eq!(&*entry.actor, "test");
        head = Head { number: entry.number, sha256: entry.sha256 };
    }
    entries
}

fn event(place: &Values) -> Event {
    Event { reason: Some("slope".to_owned()), by: actor(), created_at: place.now() }
}

/// What there are digests of, behind the salt.
fn names(contents: &Contents) -> Vec<&str> {
    let mut names: Vec<&str> = contents.iter().map(|(name, _)| name).collect();
    assert_eq!(names.remove(0), "_salt");
    names
}

/// Two digests behind their lengths.
fn digest_of(salt: &[u8; 32], digest: &[u8; 32]) -> [u8; 32] {
    let length = 32_u64.to_be_bytes();
    Sha256::digest([&length[..], salt, &length, digest].concat()).into()
}

/// Every kind of write, and the entry that it left.
#[rustfmt::skip]
pub async fn each_change_leaves_one_entry(pair: &mut Pair) {
    let (store, place, none) = (pair.store.clone(), pair.values.clone(), Precondition::None);
    let job = place.job("wheel");
    store.insert_job(job.clone(), None).await.unwrap();
    let mut told: Vec<(&str, String, Vec<&str>)> = Vec::new();
    let path = format!("/v1/jobs/{}", job.id);
    told.push(("job.create", path.clone(), vec!["job"]));
    let patch = JobPatch { name: Some("pinion".to_owned()), ..JobPatch::default() };
    store.patch_job(job.id, patch.clone(), none.clone(), place.now()).await.unwrap();
    told.push(("job.change", path.clone(), vec!["job"]));
    // the same once more changes nothing
    store.patch_job(job.id, patch, none.clone(), place.now()).await.unwrap();
    let (first, _) = place.stored_iteration(&store, job.id).await;
    let one = format!("{path}/iterations/1");
    told.push(("iteration.add", one.clone(), vec!["choice", "fit", "iteration", "nodes"]));
    let fit = Arc::new(place.fit(0.5));
    store.insert_fit(job.id, 1, fit.clone(), None).await.unwrap();
    told.push(("fit.add", format!("{one}/fits/{}", fit.id), vec!["fit"]));
    let choice = Choice { fit_id: fit.id, event: event(&place) };
    store.choose(job.id, 1, choice.clone(), none.clone()).await.unwrap();
    store.choose(job.id, 1, choice, none.clone()).await.unwrap();
    told.push(("fit.choose", format!("{one}/fits/{}", fit.id), vec!["choice"]));
    let decision = DecisionEvent { decision: Decision::Remachine, concession: false, event: event(&place) };
    store.decide(job.id, 1, decision.clone(), none.clone()).await.unwrap();
    store.decide(job.id, 1, decision, none.clone()).await.unwrap();
    told.push(("iteration.decide", one.clone(), vec!["decision"]));
    let record = place.stored_record(&store, job.id).await;
    told.push(("record.add", format!("{one}/records/{}", record.id), vec!["record"]));
    let streams = [(); 2].map(|()| Arc::new(place.stream(job.id)));
    for stream in &streams {
        store.insert_stream(stream.clone(), None).await.unwrap();
        told.push(("stream.open", format!("/v1/streams/{}", stream.id), vec!["stream"]));
    }
    store.insert_block(place.block(streams[0].id, 1), None).await.unwrap();
    told.push(("stream.block", format!("/v1/streams/{}/blocks/1", streams[0].id), vec!["block"]));
    let iteration = place.iteration(job.id);
    let finished = FinishedStream { stream: streams[0].id, sequence: 1, iteration };
    store.finish_stream(finished, None).await.unwrap();
    told.push(("stream.finish", format!("{path}/iterations/2"), vec!["choice", "fit", "iteration", "nodes"]));
    store.delete_stream(streams[1].id, none.clone(), place.now()).await.unwrap();
    told.push(("stream.delete", format!("/v1/streams/{}", streams[1].id), vec![]));
    let found = entries(&store, job.id).await;
    let found: Vec<_> = found.iter().map(|e| (&*e.action, e.target.clone(), names(&e.contents))).collect();
    assert_eq!(found, told);
    let added = entries(&store, job.id).await.swap_remove(2).contents;
    let salt = added.get("_salt").unwrap();
    assert_eq!(added.get("fit"), Some(&digest_of(salt, &first.fit.digest())));
    let salts: BTreeSet<_> = entries(&store, job.id).await.iter().map(|e| *e.contents.get("_salt").unwrap()).collect();
    assert_eq!(salts.len(), told.len(), "each has its own");
    // a job that is gone leaves its chain; one stored with its iterations has an entry for each
    let empty = place.stored_job(&store).await.id;
    store.delete_job(empty, none).await.unwrap();
    let actions = |entries: Vec<Entry>| entries.iter().map(|e| e.action.to_string()).collect::<Vec<_>>();
    assert_eq!(actions(entries(&store, empty).await), ["job.create", "job.delete"]);
    let run = place.job("run");
    let mut with_record = place.iteration(run.id);
    Arc::make_mut(&mut with_record).records = vec![(*place.record(RecordKind::Curve, "lagrange")).clone(); 1];
    let iterations = vec![with_record, place.iteration(run.id)];
    store.insert_runs(vec![NewRun { job: run.clone(), iterations }], None, place.now()).await.unwrap();
    let of_run = entries(&store, run.id).await;
    assert_eq!(names(&of_run[1].contents), ["choice", "fit", "iteration", "nodes", "record.1"]);
    assert_eq!(actions(of_run), ["job.create", "iteration.add", "iteration.add"]);
    // in pages
    let page = store.audit(Chain::Job(job.id), flankfit::jobs::PageRequest { limit: 3, after: None }).await.unwrap();
    assert_eq!((page.items.len(), page.next.map(|cursor| cursor.number())), (3, Some(3)));
    assert_eq!(store.audit(Chain::Tenant, WHOLE).await.unwrap().items, []);
}

pub async fn what_is_refused_leaves_none(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let stored = store.insert_iteration(place.iteration(job), Some(receipt("k", "POST /there"))).await;
    stored.unwrap();
    let before = entries(&store, job).await;
    let seen = Precondition::AnyOf(vec![77]);
    let refused: [Result<(), RepositoryError>; 8] = [
        store.insert_iteration(place.iteration(job), Some(receipt("k", "POST /there"))).await.map(drop),
        store.insert_fit(job, 1, Arc::new(place.fit(0.5)), Some(receipt("k", "POST /there"))).await.map(drop),
        store.insert_fit(job, 9, Arc::new(place.fit(0.5)), None).await.map(drop),
        store.patch_job(job, JobPatch::default(), seen.clone(), place.now()).await.map(drop),
        store.delete_job(job, Precondition::None).await,
        store.choose(job, 1, Choice { fit_id: place.id(), event: event(&place) }, Precondition::None).await.map(drop),
        store
            .decide(job, 1, DecisionEvent { decision: Decision::Accept, concession: false, event: event(&place) }, seen)
            .await
            .map(drop),
        store.insert_block(place.block(place.id(), 1), None).await.map(drop),
    ];
    assert!(refused.iter().all(Result::is_err), "{refused:?}");
    assert_eq!(entries(&store, job).await, before);
    // a job that there is not has no chain either
    assert!(store.audit(Chain::Job(place.id()), WHOLE).await.is_err());
}

/// Its first entry holds the digest of what was there, whichever write comes first.
pub async fn a_job_that_is_older_begins_with_what_was_found(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let mut found = Vec::new();
    for by_iteration in [true, false] {
        let job = place.stored_job(&store).await.id;
        place.stored_iteration(&store, job).await;
        place.stored_record(&store, job).await;
        pair.ground.intrude("DELETE FROM audit".to_owned()).await;
        assert_eq!(entries(&store, job).await, []);
        match by_iteration {
            true => drop(place.stored_iteration(&store, job).await),
            false => drop(store.insert_fit(job, 1, Arc::new(place.fit(0.5)), None).await.unwrap()),
        }
        let told = entries(&store, job).await;
        let second = if by_iteration { "iteration.add" } else { "fit.add" };
        assert_eq!(told.iter().map(|entry| &*entry.action).collect::<Vec<_>>(), ["audit.begin", second]);
        found.push(*told[0].contents.get("found").unwrap());
        assert_eq!(&*told[0].outcome, "found");
    }
    assert_ne!(found[0], found[1]);
}

pub async fn chains_of_many_writers_have_no_gaps(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    place.stored_iteration(&store, job).await;
    let mut tasks = JoinSet::new();
    for i in 0..90_u32 {
        let (place, store) = (place.clone(), store.clone());
        tasks.spawn(async move {
            match i % 3 {
                0 => store.insert_iteration(place.iteration(job), None).await.map(drop),
                1 => store.insert_fit(job, 1, Arc::new(place.fit(f64::from(i))), None).await.map(drop),
                _ => store.insert_record(job, 1, place.record(RecordKind::Curve, "newton"), None).await.map(drop),
            }
        });
    }
    for outcome in tasks.join_all().await {
        outcome.unwrap();
    }
    assert_eq!(entries(&store, job).await.len(), 92);
}
