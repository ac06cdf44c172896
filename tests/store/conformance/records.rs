//! Curves and surfaces kept with an iteration.

use std::sync::Arc;

use flankfit::jobs::{
    ExpectedGear, JobGear, NewIteration, PageRequest, Record, RecordKind, Repository, RepositoryError, Resource,
};
use uuid::Uuid;

use super::pair::Pair;

async fn page(store: &Arc<dyn Repository>, job: Uuid, request: PageRequest) -> (Vec<Uuid>, PageRequest, bool) {
    let page = store.records(job, 1, request).await.unwrap();
    let last = page.next.is_none();
    (page.items.iter().map(|item| item.id).collect(), PageRequest { after: page.next, ..request }, last)
}

pub async fn records_come_back_as_they_were_kept_and_page_by_page(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    place.stored_iteration(&store, job.id).await;
    let before = store.iteration(job.id, 1).await.unwrap();
    let mut kept = Vec::new();
    for (kind, method) in
        [(RecordKind::Curve, "lagrange"), (RecordKind::Surface, "coons_bilinear"), (RecordKind::Curve, "cubic_spline")]
    {
        let record = place.record(kind, method);
        let stored = store.insert_record(job.id, 1, record.clone(), None).await.unwrap();
        assert_eq!((stored.number, stored.version), (1, before.version));
        kept.push(record);
    }
    assert_eq!(store.iteration(job.id, 1).await.unwrap(), before, "the iteration is as it was");
    pair.reopen().await;

    let store = pair.store.clone();
    for record in &kept {
        assert_eq!(&store.record(job.id, 1, record.id).await.unwrap(), &**record);
    }
    let two = PageRequest { limit: 2, after: None };
    let (first, next, last) = page(&store, job.id, two).await;
    assert_eq!((first, last), (vec![kept[0].id, kept[1].id], false));
    let (second, _, last) = page(&store, job.id, next).await;
    assert_eq!((second, last), (vec![kept[2].id], true));
    let all = store.records(job.id, 1, PageRequest { limit: 3, after: None }).await.unwrap();
    assert_eq!(all.next, None, "a page that is just full is the last one");
    assert_eq!((all.items[1].kind, all.items[1].method.as_str()), (RecordKind::Surface, "coons_bilinear"));
}

/// Whatever kinds there are, the database takes them all.
pub async fn every_kind_of_record_is_kept(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    place.stored_iteration(&store, job.id).await;
    let kept = RecordKind::ALL.map(|kind| place.record(kind, kind.name()));
    for record in &kept {
        store.insert_record(job.id, 1, record.clone(), None).await.unwrap();
    }
    pair.reopen().await;
    let store = pair.store.clone();
    for record in &kept {
        let latest = store.latest_record(job.id, 1, record.draft.kind).await.unwrap();
        assert_eq!(latest.as_ref(), Some(&**record), "{:?}", record.draft.kind);
    }
    let all = store.records(job.id, 1, PageRequest { limit: 20, after: None }).await.unwrap();
    assert_eq!(all.items.iter().map(|item| item.kind).collect::<Vec<_>>(), RecordKind::ALL);
}

pub async fn a_record_belongs_to_one_iteration(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    let other = place.stored_job(&store).await;
    for job in [job.id, other.id] {
        place.stored_iteration(&store, job).await;
    }
    let kept = place.stored_record(&store, job.id).await;
    let missing = async |job, number, id| match store.record(job, number, id).await {
        Err(RepositoryError::NotFound(what)) => what,
        found => panic!("{found:?}"),
    };
    assert_eq!(missing(other.id, 1, kept.id).await, Resource::Record);
    assert_eq!(missing(job.id, 2, kept.id).await, Resource::Iteration);
    assert_eq!(missing(place.id(), 1, kept.id).await, Resource::Job);
    let refused = store.insert_record(job.id, 2, place.record(RecordKind::Curve, "newton"), None).await;
    assert!(matches!(refused, Err(RepositoryError::NotFound(Resource::Iteration))), "{refused:?}");
}

/// An import stores nodes, their fit and records of them, all or nothing.
pub async fn an_iteration_comes_with_its_records(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    let imported = |gear: Option<JobGear>| {
        let mut records =
            [place.record(RecordKind::Evaluation, "traces"), place.record(RecordKind::Deviations, "points")]
                .map(|record| Record::clone(&record));
        records[0].draft.gear = job.gear.as_deref().map(Into::into);
        let expected_gear = Some(ExpectedGear(gear));
        Arc::new(NewIteration {
            records: records.into(),
            expected_gear,
            ..NewIteration::clone(&place.iteration(job.id))
        })
    };
    let refused = store.insert_iteration(imported(None), None).await;
    assert!(matches!(refused, Err(RepositoryError::GearChanged)), "{refused:?}");
    assert_eq!(store.last_event(job.id).await.unwrap(), 0);
    let new = imported(job.gear.clone());
    store.insert_iteration(new.clone(), None).await.unwrap();
    for record in &new.records {
        assert_eq!(store.record(job.id, 1, record.id).await.unwrap(), *record);
        assert_eq!(store.latest_record(job.id, 1, record.draft.kind).await.unwrap().as_ref(), Some(record));
    }
    assert_eq!(store.latest_record(job.id, 1, RecordKind::Curve).await.unwrap(), None);
    let ids: Vec<Uuid> = new.records.iter().map(|record| record.id).collect();
    assert_eq!(page(&store, job.id, PageRequest { limit: 5, after: None }).await.0, ids);
    let traced = store.trace(job.id, PageRequest { limit: 5, after: None }).await.unwrap().iterations.remove(0);
    assert_eq!(traced.records.iter().map(|record| record.id).collect::<Vec<_>>(), ids);
    // the iteration and each record are an event, and records no version
    assert_eq!((store.last_event(job.id).await.unwrap(), store.iteration(job.id, 1).await.unwrap().version), (3, 1));
}
