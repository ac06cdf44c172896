//! No entry, no change: where the audit does not take the entry, nothing of the change is stored.

use std::{collections::BTreeSet, fmt::Debug, sync::Arc};

use flankfit::jobs::{
    Amendment, Choice, Decision, DecisionEvent, Event, FinishedStream, JobPatch, KeyId, KeyPatch, Measurand, NewPlant,
    NewRun, PlantPatch, Precondition, Receipt, Record, RecordKind, RepositoryError, Rotation, Tenant,
};
use uuid::Uuid;

use super::{
    keys::{HOUR, key, plant},
    pair::Pair,
    recorder::writes,
    tenants::{Possessions, SCOPE, everything, possessions},
};
use crate::support::{WHOLE, actor, intact, purge_of, receipt};

/// Operations that are no change of data: work to be done or withdrawn, and proposals.
const NOT_ENTERED: [&str; 1] = ["keep_mapping"];

/// Rows that can be changed.
struct Changeable {
    own: Possessions,
    /// A fit of its first iteration that is not chosen.
    fit: Uuid,
    /// A job without anything, which may be deleted.
    bare: Uuid,
    /// A job to be purged.
    old: Uuid,
    key: KeyId,
}

async fn changeable(pair: &Pair) -> Changeable {
    let (store, place, tenant) = (pair.store.clone(), pair.values.clone(), Tenant::default());
    let own = possessions(&store, &place).await;
    let fit = Arc::new(place.fit(0.5));
    store.insert_fit(own.job, 1, fit.clone(), None).await.unwrap();
    let bare = place.stored_job(&store).await.id;
    let old = place.stored_job(&store).await.id;
    place.stored_iteration(&store, old).await;
    let new = key(&place, &tenant, None);
    pair.keys_of(&tenant).insert_key(Arc::new(new.clone()), None).await.unwrap();
    Changeable { own, fit: fit.id, bare, old, key: new.key.id }
}

/// Everything that can be read of it, and of what might have come to it.
async fn read(pair: &Pair, of: &Changeable) -> String {
    let (store, tenant) = (&pair.store, Tenant::default());
    let (keys, root) = (pair.keys_of(&tenant), pair.keys_of(&Tenant::root()));
    let all: [Box<dyn Debug>; 8] = [
        Box::new(everything(store, &of.own).await),
        Box::new(store.streams(of.own.job, WHOLE).await.unwrap()),
        Box::new(store.job(of.bare).await.unwrap()),
        Box::new(store.trace(of.old, WHOLE).await.unwrap()),
        Box::new(store.nodes(of.old, 1).await.unwrap()),
        Box::new(store.audit(None, WHOLE).await.unwrap()),
        Box::new(keys.keys(WHOLE).await.unwrap()),
        Box::new(root.plants(WHOLE).await.unwrap()),
    ];
    format!("{all:?}")
}

/// A receipt of a key of its own.
fn kept(write: &str) -> Option<Receipt> {
    Some(receipt(&format!("of {write}"), SCOPE))
}

type Outcomes = Vec<(&'static str, Result<(), RepositoryError>)>;

/// Every write of a job that is entered, once.
async fn written(pair: &Pair, of: &Changeable) -> Outcomes {
    let (store, place, none) = (&pair.store, &pair.values, Precondition::None);
    let Possessions { job, stream, empty, .. } = of.own;
    let event = || Event { reason: Some("slope".to_owned()), by: actor(), created_at: place.now() };
    let mut all: Outcomes = Vec::new();
    let new = place.job("new");
    all.push(("insert_job", store.insert_job(new, kept("insert_job")).await.map(drop)));
    let patch = JobPatch { name: Some("pinion".to_owned()), ..JobPatch::default() };
    all.push(("patch_job", store.patch_job(job, patch, none.clone(), place.now()).await.map(drop)));
    let run = place.job("run");
    let runs = vec![NewRun { iterations: vec![place.iteration(run.id)], job: run }];
    all.push(("insert_runs", store.insert_runs(runs, kept("insert_runs"), place.now()).await.map(drop)));
    let iteration = store.insert_iteration(place.iteration(job), kept("insert_iteration")).await;
    all.push(("insert_iteration", iteration.map(drop)));
    let fit = Arc::new(place.fit(0.25));
    all.push(("insert_fit", store.insert_fit(job, 1, fit, kept("insert_fit")).await.map(drop)));
    let choice = Choice { fit_id: of.fit, event: event() };
    all.push(("choose", store.choose(job, 1, choice, none.clone()).await.map(drop)));
    let decision = DecisionEvent { decision: Decision::Remachine, concession: false, event: event() };
    all.push(("decide", store.decide(job, 1, decision, none.clone()).await.map(drop)));
    let mut changed = Record::clone(&place.record(RecordKind::Measurand, "changed"));
    changed.draft.measurand = Some("{}".into());
    let amendment = Amendment { measurand: Measurand::default(), record: changed, fit: None, decision: None };
    all.push(("amend", store.amend(job, 1, Arc::new(amendment), none.clone()).await.map(drop)));
    let record = place.record(RecordKind::Curve, "newton");
    all.push(("insert_record", store.insert_record(job, 1, record, kept("insert_record")).await.map(drop)));
    let opened = Arc::new(place.stream(job));
    all.push(("insert_stream", store.insert_stream(opened, kept("insert_stream")).await.map(drop)));
    let block = store.insert_block(place.block(empty, 1), kept("insert_block")).await;
    all.push(("insert_block", block.map(drop)));
    let finished = FinishedStream { stream, sequence: 1, iteration: place.iteration(job) };
    all.push(("finish_stream", store.finish_stream(finished, kept("finish_stream")).await.map(drop)));
    all.push(("delete_stream", store.delete_stream(empty, none.clone(), place.now()).await));
    all.push(("delete_job", store.delete_job(of.bare, none).await));
    let purge = purge_of(place, of.old);
    all.push(("purge_job", store.purge_job(purge, kept("purge_job")).await.map(drop)));
    all
}

/// Every write of keys and tenants, once.
async fn administered(pair: &Pair, of: &Changeable) -> Outcomes {
    let (place, none, tenant) = (&pair.values, Precondition::None, Tenant::default());
    let (keys, root) = (pair.keys_of(&tenant), pair.keys_of(&Tenant::root()));
    let mut all: Outcomes = Vec::new();
    let new = Arc::new(key(place, &tenant, None));
    all.push(("insert_key", keys.insert_key(new, kept("insert_key")).await.map(drop)));
    let patch = KeyPatch { name: Some("other".to_owned()), expires_at: None };
    all.push(("patch_key", keys.patch_key(of.key, patch, none.clone(), place.now()).await.map(drop)));
    let rotation = Rotation { of: of.key, old_ends: place.now() + HOUR, new: key(place, &tenant, None) };
    all.push(("rotate_key", keys.rotate_key(Arc::new(rotation), kept("rotate_key")).await.map(drop)));
    all.push(("revoke_key", keys.revoke_key(of.key, place.now()).await));
    let name = Tenant::named("plant-7").unwrap();
    let new = NewPlant { plant: plant(place, "plant-7"), key: key(place, &name, None) };
    all.push(("insert_plant", root.insert_plant(Arc::new(new), kept("insert_plant")).await.map(drop)));
    let patch = PlantPatch { description: Some("hall 2".to_owned()), suspended: None };
    all.push(("patch_plant", root.patch_plant(tenant, patch, none, place.now()).await.map(drop)));
    all
}

pub async fn changes_without_audit_entry_are_refused(pair: &mut Pair) {
    let of = changeable(pair).await;
    let before = read(pair, &of).await;
    pair.ground.refuse_entries(true).await;
    let mut tried = BTreeSet::from(NOT_ENTERED);
    for (write, outcome) in written(pair, &of).await.into_iter().chain(administered(pair, &of).await) {
        assert!(matches!(outcome, Err(RepositoryError::Failed(_))), "{write}: {outcome:?}");
        tried.insert(write);
    }
    assert_eq!(tried, writes(), "every write is tried");
    assert_eq!(read(pair, &of).await, before);
    // nothing else was in their way, and their keys are as free as before
    pair.ground.refuse_entries(false).await;
    for (write, outcome) in written(pair, &of).await.into_iter().chain(administered(pair, &of).await) {
        assert!(outcome.is_ok(), "{write}: {outcome:?}");
    }
    intact(&pair.handles[0]).await;
}
