//! Each change leaves one entry; what changes nothing leaves none. The sealer makes a chain of
//! them.

use std::{collections::BTreeSet, sync::Arc};

use flankfit::jobs::{
    Choice, Decision, DecisionEvent, Event, FinishedStream, JobPatch, KeyPatch, NewPlant, NewRun, PageRequest,
    PlantPatch, Precondition, RecordKind, Repository, RepositoryError, Rotation, Tenant,
    audit::{Evidence, Kind, Link, ListedEntry, Seal, Sealing, examine},
};
use tokio::task::JoinSet;
use uuid::Uuid;

use super::{
    keys::{HOUR, key, plant},
    pair::Pair,
    purges::{filled, purged},
};
use crate::support::{Values, WHOLE, actor, intact, receipt, sealed, verified};

/// The entries of a job, or of a tenant.
pub async fn entries(store: &Arc<dyn Repository>, job: Option<Uuid>) -> Vec<ListedEntry> {
    store.audit(job, WHOLE).await.unwrap().items
}

/// Actions with their subjects and the rows they left.
fn summaries(entries: &[ListedEntry]) -> BTreeSet<(String, String, Vec<String>)> {
    let rows = |listed: &ListedEntry| listed.entry.contents.iter().map(|(name, _)| name.to_owned()).collect();
    let one = |listed: &ListedEntry| (listed.entry.action.to_string(), listed.entry.subject.clone(), rows(listed));
    entries.iter().map(one).collect()
}

fn event(place: &Values) -> Event {
    Event { reason: Some("slope".to_owned()), by: actor(), created_at: place.now() }
}

/// Every kind of write of a job, and the entry that it left.
#[rustfmt::skip]
pub async fn each_change_leaves_one_entry(pair: &mut Pair) {
    let (store, place, none) = (pair.store.clone(), pair.values.clone(), Precondition::None);
    let job = place.job("wheel");
    store.insert_job(job.clone(), None).await.unwrap();
    let mut expected = BTreeSet::new();
    let path = format!("/v1/jobs/{}", job.id);
    let mut expect = |action: &str, subject: String, rows: &[&str]| {
        let rows = rows.iter().map(|row| (*row).to_owned()).collect();
        assert!(expected.insert((action.to_owned(), subject, rows)));
    };
    expect("job.create", path.clone(), &["jobs/1"]);
    let patch = JobPatch { name: Some("pinion".to_owned()), ..JobPatch::default() };
    store.patch_job(job.id, patch.clone(), none.clone(), place.now()).await.unwrap();
    expect("job.change", path.clone(), &["events/1", "jobs/2"]);
    // the same once more changes nothing
    store.patch_job(job.id, patch, none.clone(), place.now()).await.unwrap();
    place.stored_iteration(&store, job.id).await;
    let one = format!("{path}/iterations/1");
    expect("iteration.add", one.clone(), &["fit_choices/1/1", "fits/1/1", "iterations/1", "nodes/1"]);
    let fit = Arc::new(place.fit(0.5));
    store.insert_fit(job.id, 1, fit.clone(), None).await.unwrap();
    expect("fit.add", format!("{one}/fits/{}", fit.id), &["fits/1/2"]);
    let choice = Choice { fit_id: fit.id, event: event(&place) };
    store.choose(job.id, 1, choice.clone(), none.clone()).await.unwrap();
    store.choose(job.id, 1, choice, none.clone()).await.unwrap();
    expect("fit.choose", format!("{one}/fits/{}", fit.id), &["fit_choices/1/2"]);
    let decision = DecisionEvent { decision: Decision::Remachine, concession: false, event: event(&place) };
    store.decide(job.id, 1, decision.clone(), none.clone()).await.unwrap();
    store.decide(job.id, 1, decision, none.clone()).await.unwrap();
    expect("iteration.decide", one.clone(), &["decisions/1/1"]);
    let record = place.stored_record(&store, job.id).await;
    expect("record.add", format!("{one}/records/{}", record.id), &["records/1/1"]);
    let [first, second] = [(); 2].map(|()| Arc::new(place.stream(job.id)));
    let events = store.last_event(job.id).await.unwrap();
    let of = |stream: Uuid, version: u64| format!("streams/{stream}/{version}");
    for (stream, event) in [(&first, events + 1), (&second, events + 2)] {
        store.insert_stream(stream.clone(), None).await.unwrap();
        expect("stream.open", format!("/v1/streams/{}", stream.id), &[&format!("events/{event}"), &of(stream.id, 1)]);
    }
    store.insert_block(place.block(first.id, 1), None).await.unwrap();
    let event = format!("events/{}", events + 3);
    let rows = ["stream_blocks", "stream_states"].map(|table| format!("{table}/{}/1", first.id));
    expect("stream.block", format!("/v1/streams/{}/blocks/1", first.id), &[&event, &rows[0], &rows[1], &of(first.id, 2)]);
    let finished = FinishedStream { stream: first.id, sequence: 1, iteration: place.iteration(job.id) };
    store.finish_stream(finished, None).await.unwrap();
    let (event, last) = (format!("events/{}", events + 5), of(first.id, 3));
    let rows = [&*event, "fit_choices/2/1", "fits/2/1", "iterations/2", "nodes/2", &*last];
    expect("stream.finish", format!("{path}/iterations/2"), &rows);
    store.delete_stream(second.id, none.clone(), place.now()).await.unwrap();
    expect("stream.delete", format!("/v1/streams/{}", second.id), &[&format!("events/{}", events + 6)]);
    let found = entries(&store, Some(job.id)).await;
    assert_eq!(summaries(&found), expected);
    assert_eq!(found.len(), expected.len());
    let salts: BTreeSet<_> = found.iter().map(|listed| listed.entry.salt.clone().unwrap()).collect();
    assert_eq!(salts.len(), found.len(), "each has its own");
    // a job that was deleted leaves its entries; one stored with iterations has an entry for each
    let empty = place.stored_job(&store).await.id;
    store.delete_job(empty, none).await.unwrap();
    let actions = |entries: Vec<ListedEntry>| {
        let actions: BTreeSet<String> = entries.iter().map(|listed| listed.entry.action.to_string()).collect();
        actions.into_iter().collect::<Vec<_>>()
    };
    assert_eq!(actions(entries(&store, Some(empty)).await), ["job.create", "job.delete"]);
    let run = place.job("run");
    let mut with_record = place.iteration(run.id);
    Arc::make_mut(&mut with_record).records = vec![(*place.record(RecordKind::Curve, "lagrange")).clone(); 1];
    let iterations = vec![with_record, place.iteration(run.id)];
    store.insert_runs(vec![NewRun { job: run.clone(), iterations }], None, place.now()).await.unwrap();
    let of_run = entries(&store, Some(run.id)).await;
    assert!(summaries(&of_run).iter().any(|(_, _, rows)| rows.contains(&"records/1/1".to_owned())));
    assert_eq!((of_run.len(), actions(of_run)), (3, vec!["iteration.add".to_owned(), "job.create".to_owned()]));
    // in pages, and the tenant's all together
    let page = store.audit(Some(job.id), PageRequest { limit: 3, after: None }).await.unwrap();
    let next = store.audit(Some(job.id), PageRequest { limit: 200, after: page.next }).await.unwrap();
    assert_eq!([page.items, next.items].concat(), entries(&store, Some(job.id)).await);
    assert_eq!(entries(&store, None).await.len(), found.len() + 5);
    intact(&pair.handles[0]).await;
}

pub async fn changes_of_keys_and_tenants_are_entered(pair: &mut Pair) {
    let (place, none, tenant) = (pair.values.clone(), Precondition::None, Tenant::named("plant-7").unwrap());
    let (keys, root) = (pair.keys_of(&tenant), pair.keys_of(&Tenant::root()));
    let first = key(&place, &tenant, None);
    let id = first.key.id;
    let new = NewPlant { plant: plant(&place, "plant-7"), key: first };
    root.insert_plant(Arc::new(new), None).await.unwrap();
    let patch = PlantPatch { description: Some("hall 2".to_owned()), suspended: None };
    root.patch_plant(tenant.clone(), patch, none.clone(), place.now()).await.unwrap();
    let patch = KeyPatch { name: Some("other".to_owned()), expires_at: None };
    keys.patch_key(id, patch, none, place.now()).await.unwrap();
    let rotation = Rotation { of: id, old_ends: place.now() + HOUR, new: key(&place, &tenant, None) };
    let next = rotation.new.key.id;
    keys.rotate_key(Arc::new(rotation), None).await.unwrap();
    keys.revoke_key(next, place.now()).await.unwrap();
    keys.revoke_key(next, place.now()).await.unwrap();
    let found = summaries(&entries(&pair.seen_by("plant-7"), None).await);
    let of = |id, version: u64| format!("api_keys/{id}/{version}");
    let expected = [
        ("tenant.create", "/v1/tenants/plant-7".to_owned(), vec![of(id, 1), "tenants/plant-7/1".to_owned()]),
        ("tenant.change", "/v1/tenants/plant-7".to_owned(), vec!["tenants/plant-7/2".to_owned()]),
        ("key.change", format!("/v1/keys/{id}"), vec![of(id, 2)]),
        ("key.rotate", format!("/v1/keys/{id}"), BTreeSet::from([of(id, 3), of(next, 1)]).into_iter().collect()),
        ("key.revoke", format!("/v1/keys/{next}"), vec![of(next, 2)]),
    ];
    let expected = expected.map(|(action, subject, rows)| (action.to_owned(), subject, rows));
    assert_eq!(found, BTreeSet::from(expected));
    intact(&pair.handles[0]).await;
}

pub async fn refused_changes_leave_no_entry(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    store.insert_iteration(place.iteration(job), Some(receipt("k", "POST /there"))).await.unwrap();
    let before = entries(&store, Some(job)).await;
    let seen = Precondition::AnyOf(vec![77]);
    let refused: [Result<(), RepositoryError>; 8] = [
        store.insert_iteration(place.iteration(job), Some(receipt("k", "POST /there"))).await.map(drop),
        store.insert_fit(job, 1, Arc::new(place.fit(0.5)), Some(receipt("k", "POST /there"))).await.map(drop),
        store.insert_fit(job, 9, Arc::new(place.fit(0.5)), None).await.map(drop),
        store.patch_job(job, JobPatch::default(), seen.clone(), place.now()).await.map(drop),
        store.delete_job(job, Precondition::None).await,
        store.choose(job, 1, Choice { fit_id: place.id(), event: event(&place) }, Precondition::None).await.map(drop),
        store
            .decide(
                job,
                1,
                DecisionEvent { decision: Decision::Accepted, concession: false, event: event(&place) },
                seen,
            )
            .await
            .map(drop),
        store.insert_block(place.block(place.id(), 1), None).await.map(drop),
    ];
    assert!(refused.iter().all(Result::is_err), "{refused:?}");
    assert_eq!(entries(&store, Some(job)).await, before);
    // a job that there is not has no entries either
    assert!(store.audit(Some(place.id()), WHOLE).await.is_err());
}

/// While they write, somebody seals.
pub async fn many_writers_leave_one_chain_without_gaps(pair: &mut Pair) {
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
    let mut seals = Vec::new();
    while let Some(outcome) = tasks.join_next().await {
        outcome.unwrap().unwrap();
        seals.extend(sealed(&pair.handles[0], place.now()).await);
    }
    seals.extend(sealed(&pair.handles[1], place.now()).await);
    assert_eq!(sealed(&pair.handles[1], place.now()).await, [], "all is sealed");
    let found = entries(&store, Some(job)).await;
    let numbers: BTreeSet<u64> = found.iter().map(|listed| listed.place.unwrap().number).collect();
    assert_eq!(numbers, (1..=92).collect());
    assert!(seals.windows(2).all(|two| (two[1].number, two[1].previous) == (two[0].number + 1, two[0].sha256)));
    assert_eq!(seals.last().unwrap().last.number, 92);
    assert_eq!(store.seals(WHOLE).await.unwrap().items, seals);
    let verdict = intact(&pair.handles[1]).await;
    assert_eq!((verdict.entries, verdict.unsealed, verdict.seals), (92, 0, seals.len() as u64));
}

/// The owner of the database can write all of it anew, but not the seals that are kept elsewhere.
pub async fn a_rewritten_chain_contradicts_its_seals(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let first = sealed(&pair.handles[0], place.now()).await.remove(0);
    place.stored_iteration(&store, job).await;
    let second = sealed(&pair.handles[1], place.now()).await.remove(0);
    let against = async |kept: &[Seal]| {
        let evidence = Evidence::of(kept.to_vec(), None).unwrap();
        examine(&*pair.handles[0].auditor(), None, None, &evidence, &|_| {}).await.unwrap().differences
    };
    assert_eq!(against(&[first.clone(), second.clone()]).await, [].into());
    let mut forged = second.clone();
    forged.last = Link { number: 1, sha256: [7; 32] };
    assert!(Evidence::of(vec![first.clone(), forged], None).is_err(), "a seal that is not as it was made");
    assert!(Evidence::of(vec![first.clone()], Some([7; 32])).is_err(), "nobody signed it");
    // the last change is undone, with its entry and its seal: nothing in the database shows it
    let undo = "DELETE FROM audit_seals WHERE number = 2; DELETE FROM audit_chain WHERE number = 2;
                DELETE FROM audit WHERE action = 'iteration.add'; DELETE FROM events; DELETE FROM flanks;
                DELETE FROM fit_choices; DELETE FROM fits; DELETE FROM nodes; DELETE FROM iterations;
                UPDATE jobs SET iteration_count = 0, status = 'new', changed_at = updated_at";
    pair.ground.intrude(undo.to_owned()).await;
    intact(&pair.handles[0]).await;
    let differences: Vec<_> =
        against(&[first, second]).await.into_iter().map(|difference| (difference.place, difference.kind)).collect();
    assert_eq!(differences, [("entry 2".to_owned(), Kind::Missing), ("seal 2".to_owned(), Kind::Missing)]);
}

/// Personal data are removed, and what is left is guarded as before.
pub async fn purged_names_cannot_be_guessed(pair: &mut Pair) {
    let job = filled(pair).await;
    sealed(&pair.handles[0], pair.values.now()).await;
    let before = entries(&pair.store, Some(job)).await;
    purged(pair, job).await;
    sealed(&pair.handles[0], pair.values.now()).await;
    let after = entries(&pair.store, Some(job)).await;
    assert_eq!(after.len(), before.len() + 1);
    let (purge, others): (Vec<_>, Vec<_>) = after.iter().partition(|listed| listed.entry.action == "job.purge");
    assert!(purge[0].entry.actor.is_some() && purge[0].entry.salt.is_some());
    assert!(others.iter().all(|listed| listed.entry.actor.is_none() && listed.entry.salt.is_none()));
    intact(&pair.handles[1]).await;
    pair.ground.defenceless().await;
    for sql in [
        "UPDATE decisions SET decision = 'accepted'",
        "UPDATE fits SET rms = 1.0",
        "UPDATE iterations SET instrument = 'x'",
        "UPDATE audit SET actor = 'x' WHERE action = 'fit.add'",
        "UPDATE jobs SET name = 'x'",
        "UPDATE purges SET reason = 'x'",
        "UPDATE records SET method = 'x'",
        "UPDATE streams SET sequence = 9",
        "DELETE FROM fit_choices",
        "DELETE FROM purges",
    ] {
        let table = sql.split(' ').find(|word| word.chars().all(|c| c.is_lowercase() || c == '_')).unwrap();
        pair.ground.intrude(format!("CREATE TABLE kept_{table} AS SELECT * FROM {table}; {sql}")).await;
        assert!(!verified(&pair.handles[0]).await.differences.is_empty(), "{sql}");
        pair.ground.intrude(format!("{}; DROP TABLE kept_{table}", pair.ground.again(table))).await;
        intact(&pair.handles[0]).await;
    }
}

/// It is reported, and its entries are sealed once it is repaired.
pub async fn one_tenants_damage_keeps_no_other_from_its_seal(pair: &mut Pair) {
    let place = pair.values.clone();
    let tenants = ["default", "damaged", "partly"].map(|tenant| pair.seen_by(tenant));
    for store in &tenants {
        place.stored_job(store).await;
    }
    let first = sealed(&pair.handles[0], place.now()).await;
    assert_eq!(first.len(), 3);
    let lost = place.stored_job(&tenants[2]).await.id;
    for store in &tenants {
        place.stored_job(store).await;
    }
    pair.ground.defenceless().await;
    let nothing = pair.ground.literal(&[0xff]);
    pair.ground.intrude(format!("UPDATE audit_seals SET sha256 = {nothing} WHERE tenant = 'damaged'")).await;
    pair.ground.intrude(format!("UPDATE audit SET who = {nothing} WHERE job = {}", pair.ground.id(lost))).await;
    let sealing = Sealing { at: place.now(), key: None };
    let turn = pair.handles[1].seal_audit(sealing.clone()).await.unwrap().unwrap();
    let whose: Vec<_> = turn.seals.iter().map(|seal| (seal.tenant.as_str(), seal.last.number)).collect();
    assert_eq!((whose, turn.more), (vec![("default", 2), ("partly", 2)], false));
    assert_eq!(turn.failed, ["1 entries cannot be read", "the end of the chain of tenant damaged cannot be read"]);
    let damaged = first.iter().find(|seal| seal.tenant.as_str() == "damaged").unwrap();
    let was = pair.ground.literal(&damaged.sha256);
    pair.ground.intrude(format!("UPDATE audit_seals SET sha256 = {was} WHERE tenant = 'damaged'")).await;
    place.stored_job(&tenants[0]).await;
    let turn = pair.handles[1].seal_audit(sealing).await.unwrap().unwrap();
    let whose: Vec<_> = turn.seals.iter().map(|seal| (seal.tenant.as_str(), seal.last.number)).collect();
    assert_eq!(whose, [("damaged", 2), ("default", 3)]);
}
