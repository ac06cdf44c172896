//! Curves and surfaces kept with an iteration.

use std::sync::Arc;

use flankfit::jobs::{PageRequest, RecordKind, Repository, RepositoryError, Resource};
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
