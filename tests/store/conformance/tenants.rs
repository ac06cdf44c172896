//! Data of one tenant do not exist for another, and nothing that the other does changes them.

use std::{fmt::Debug, sync::Arc};

use flankfit::jobs::{
    Choice, Decision, DecisionEvent, Event, FinishedStream, JobPatch, Measurand, NewIteration, Precondition,
    Predecessors, RecordKind, Repository, RepositoryError, Resource,
};
use flankfit_engine::gear::Side;
use uuid::Uuid;

use super::pair::Pair;
use crate::support::{Values, WHOLE, actor, all_jobs, receipt};

pub const SCOPE: &str = "POST /there";

/// Something of everything.
pub struct Possessions {
    pub job: Uuid,
    iteration: Arc<NewIteration>,
    record: Uuid,
    pub stream: Uuid,
    /// A stream without blocks, for requests that are refused for the tenant alone.
    pub empty: Uuid,
}

pub async fn possessions(store: &Arc<dyn Repository>, place: &Values) -> Possessions {
    let job = place.job("wheel");
    store.insert_job(job.clone(), Some(receipt("k", SCOPE))).await.unwrap();
    let (iteration, _) = place.stored_iteration(store, job.id).await;
    place.stored_iteration(store, job.id).await;
    let record = place.stored_record(store, job.id).await;
    let [stream, empty] = [(); 2].map(|()| Arc::new(place.stream(job.id)));
    store.insert_stream(stream.clone(), None).await.unwrap();
    store.insert_stream(empty.clone(), None).await.unwrap();
    store.insert_block(place.block(stream.id, 1), None).await.unwrap();
    Possessions { job: job.id, iteration, record: record.id, stream: stream.id, empty: empty.id }
}

/// Everything that can be read of it.
pub async fn everything(store: &Arc<dyn Repository>, of: &Possessions) -> String {
    let Possessions { job, iteration, record, stream, empty } = of;
    let all: [Box<dyn Debug>; 15] = [
        Box::new(store.audit(Some(*job), WHOLE).await.unwrap()),
        Box::new(store.jobs(all_jobs()).await.unwrap()),
        Box::new(store.job(*job).await.unwrap()),
        Box::new(store.trace(*job, WHOLE).await.unwrap()),
        Box::new(store.iteration(*job, 1).await.unwrap()),
        Box::new(store.nodes(*job, 1).await.unwrap()),
        Box::new(store.fits(*job, 1, WHOLE).await.unwrap()),
        Box::new(store.fit(*job, 1, iteration.fit.id).await.unwrap()),
        Box::new(store.record(*job, 1, *record).await.unwrap()),
        Box::new(store.records(*job, 1, WHOLE).await.unwrap()),
        Box::new(store.stream_state(*stream).await.unwrap()),
        Box::new(store.blocks(*stream, 0).await.unwrap().iter().map(|block| block.sha256).collect::<Vec<_>>()),
        Box::new(store.stream(*empty).await.unwrap()),
        Box::new(store.events(*job, 0, 1000).await.unwrap()),
        Box::new(store.answer("k".to_owned(), SCOPE.to_owned()).await.unwrap()),
    ];
    format!("{all:?}")
}

fn missing<T: Debug>(outcome: Result<T, RepositoryError>, what: Resource) {
    assert!(matches!(outcome, Err(RepositoryError::NotFound(missing)) if missing == what), "{what:?}: {outcome:?}");
}

pub async fn another_tenants_reads_find_nothing(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let other = pair.seen_by("other");
    let Possessions { job, iteration, record, stream, .. } = possessions(&store, &place).await;
    let found = other.jobs(all_jobs()).await.unwrap();
    assert_eq!((found.items, found.next), (Vec::new(), None));
    missing(other.job(job).await, Resource::Job);
    missing(other.iterations(job, WHOLE).await, Resource::Job);
    missing(other.trace(job, WHOLE).await, Resource::Job);
    missing(other.iteration(job, 1).await, Resource::Job);
    missing(other.nodes(job, 1).await, Resource::Job);
    missing(other.nodes_up_to(job, 1, 0).await, Resource::Job);
    missing(other.measurand(job, 1).await, Resource::Job);
    missing(other.fit(job, 1, iteration.fit.id).await, Resource::Job);
    missing(other.fits(job, 1, WHOLE).await, Resource::Job);
    missing(other.record(job, 1, record).await, Resource::Job);
    missing(other.records(job, 1, WHOLE).await, Resource::Job);
    missing(other.latest_record(job, 1, RecordKind::Curve).await, Resource::Job);
    missing(other.last_event(job).await, Resource::Job);
    missing(other.stream(stream).await, Resource::Stream);
    missing(other.stream_state(stream).await, Resource::Stream);
    missing(other.audit(Some(job), WHOLE).await.map(|page| page.items), Resource::Job);
    // what follows or precedes nothing, as for a job that there is not
    let alike = Predecessors { of: iteration.measurand.clone(), from: 1, before: None, most: 10 };
    assert_eq!(store.predecessors(job, alike.clone()).await.unwrap().len(), 2);
    assert_eq!(other.predecessors(job, alike).await.unwrap(), []);
    assert_eq!(store.successors(job, 1).await.unwrap().any, Some(2));
    assert_eq!(other.successors(job, 1).await.unwrap(), Default::default());
    assert_eq!(other.rounds(job).await.unwrap(), Default::default());
    assert_eq!(other.events(job, 0, 1000).await.unwrap(), []);
    assert!(other.blocks(stream, 0).await.unwrap().is_empty());
    assert_eq!(store.block_sha256(stream, 1).await.unwrap(), Some([1; 32]));
    assert_eq!(other.block_sha256(stream, 1).await.unwrap(), None);
    assert_eq!(other.answer("k".to_owned(), SCOPE.to_owned()).await.unwrap(), None);
}

pub async fn another_tenants_writes_change_nothing(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let other = pair.seen_by("other");
    let own = possessions(&store, &place).await;
    let before = everything(&store, &own).await;
    let Possessions { job, iteration, stream, empty, .. } = &own;
    let (job, none) = (*job, Precondition::None);
    let event = || Event { reason: None, by: actor(), created_at: place.now() };
    let patch = JobPatch { name: Some("theirs".to_owned()), ..JobPatch::default() };
    missing(other.patch_job(job, patch, none.clone(), place.now()).await, Resource::Job);
    missing(other.delete_job(job, none.clone()).await, Resource::Job);
    missing(other.insert_iteration(place.iteration(job), None).await, Resource::Job);
    missing(other.insert_fit(job, 1, Arc::new(place.fit(0.5)), None).await, Resource::Job);
    let choice = Choice { fit_id: iteration.fit.id, event: event() };
    missing(other.choose(job, 1, choice, none.clone()).await, Resource::Job);
    let decision = DecisionEvent { decision: Decision::Rejected, concession: false, event: event() };
    missing(other.decide(job, 1, decision, none.clone()).await, Resource::Job);
    missing(other.insert_record(job, 1, place.record(RecordKind::Curve, "newton"), None).await, Resource::Job);
    missing(other.insert_stream(Arc::new(place.stream(job)), None).await, Resource::Job);
    missing(other.insert_block(place.block(*empty, 1), None).await, Resource::Stream);
    let finished = FinishedStream { stream: *stream, sequence: 1, iteration: place.iteration(job) };
    missing(other.finish_stream(finished, None).await, Resource::Stream);
    missing(other.delete_stream(*stream, none.clone(), place.now()).await, Resource::Stream);
    // nor do a stream of one's own, or a key, lead into another's job
    let theirs = possessions(&other, &place).await;
    let finished = FinishedStream { stream: theirs.stream, sequence: 1, iteration: place.iteration(job) };
    missing(other.finish_stream(finished, None).await, Resource::Job);
    let keyed = other.insert_iteration(place.iteration(job), Some(receipt("new", SCOPE))).await;
    missing(keyed, Resource::Job);
    assert_eq!(everything(&store, &own).await, before);
    // and in one transaction with the owner's, the owner's alone are stored
    let (one, two) = tokio::join!(
        store.insert_iteration(place.iteration(job), None),
        other.insert_iteration(place.iteration(job), None)
    );
    assert_eq!(one.unwrap().number, 3);
    missing(two, Resource::Job);
}

/// The same key of two tenants is two keys, and their jobs are numbered and listed apart.
pub async fn tenants_do_not_meet(pair: &mut Pair) {
    let place = pair.values.clone();
    let names = ["default", "other", "third"];
    for (k, name) in names.iter().enumerate() {
        let store = pair.seen_by(name);
        for _ in 0..=k {
            place.stored_job(&store).await;
        }
        let job = store.jobs(all_jobs()).await.unwrap().items.pop().unwrap().job;
        let left =
            Measurand { flank: Some(Side::Left), tooth: Some((k + 1).to_string()), axes: None, accept_units: false };
        let iteration =
            Arc::new(NewIteration { measurand: left.clone(), ..NewIteration::clone(&place.iteration(job.id)) });
        let stored = store.insert_iteration(iteration, Some(receipt("same", SCOPE))).await.unwrap();
        assert_eq!(stored.number, 1);
        assert_eq!(store.last_event(job.id).await.unwrap(), 1);
    }
    for (k, name) in names.iter().enumerate() {
        let store = pair.seen_by(name);
        let jobs = store.jobs(all_jobs()).await.unwrap().items;
        let jobs: Vec<_> = jobs.into_iter().map(|listed| listed.job).collect();
        assert_eq!(jobs.len(), k + 1);
        assert_eq!(store.measurand(jobs[k].id, 1).await.unwrap().tooth, Some((k + 1).to_string()));
        let again = store.insert_iteration(place.iteration(jobs[k].id), Some(receipt("same", SCOPE))).await;
        assert!(matches!(again, Err(RepositoryError::KeyTaken)), "{again:?}");
    }
}
