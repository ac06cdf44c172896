//! Pages neither repeat nor skip, whatever comes and goes meanwhile.

use std::sync::Arc;

use flankfit::jobs::{PageRequest, RecordKind};
use uuid::Uuid;

use super::pair::Pair;
use crate::support::WHOLE;

/// A list that is read to its end has everything that existed when reading began, once and in
/// order, whatever is added meanwhile, through the other handle too.
pub async fn lists_that_grow_are_read_without_gaps_or_repeats(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    place.stored_iteration(&store, job).await;
    let (mut iterations, mut fits, mut records) = (vec![1], Vec::new(), Vec::new());
    fits.push(store.iteration(job, 1).await.unwrap().fits[0].id);
    let grow = async |iterations: &mut Vec<u32>, fits: &mut Vec<Uuid>, records: &mut Vec<Uuid>| {
        iterations.push(place.stored_iteration(&store, job).await.1.number);
        let fit = Arc::new(place.fit(0.5));
        store.insert_fit(job, 1, fit.clone(), None).await.unwrap();
        fits.push(fit.id);
        records.push(place.stored_record(&store, job).await.id);
    };
    for _ in 0..5 {
        grow(&mut iterations, &mut fits, &mut records).await;
    }
    let (mut told_iterations, mut told_fits, mut told_records) = (Vec::new(), Vec::new(), Vec::new());
    let page = |after| PageRequest { limit: 2, after };
    let (mut after_iteration, mut after_fit, mut after_record) = (None, None, None);
    for turn in 0..12 {
        let trace = store.trace(job, page(after_iteration)).await.unwrap();
        told_iterations.extend(trace.iterations.iter().map(|iteration| iteration.number));
        let listed = store.fits(job, 1, page(after_fit)).await.unwrap();
        told_fits.extend(listed.items.iter().map(|fit| fit.id));
        let kept = store.records(job, 1, page(after_record)).await.unwrap();
        told_records.extend(kept.items.iter().map(|record| record.id));
        let next = (trace.next, listed.next, kept.next);
        let (Some(iteration), Some(fit), Some(record)) = next else { break };
        (after_iteration, after_fit, after_record) = (Some(iteration), Some(fit), Some(record));
        if turn < 4 {
            grow(&mut iterations, &mut fits, &mut records).await;
        }
    }
    // records are one fewer than the others, so their list ends first or with them
    assert!(told_records.len() >= 8 && records.starts_with(&told_records));
    assert!(told_fits.len() >= 8 && fits.starts_with(&told_fits));
    assert!(told_iterations.len() >= 8 && iterations.starts_with(&told_iterations));
    // to their ends
    let whole = store.records(job, 1, WHOLE).await.unwrap();
    assert_eq!(whole.items.iter().map(|record| record.id).collect::<Vec<_>>(), records);
    let whole = store.fits(job, 1, WHOLE).await.unwrap();
    assert_eq!(whole.items.iter().map(|fit| fit.id).collect::<Vec<_>>(), fits);
}

/// The clocks of several servers differ: what was kept last is the latest, whatever its id.
pub async fn the_order_is_that_of_storing_not_of_ids(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    place.stored_iteration(&store, job).await;
    let early = [place.record(RecordKind::Curve, "early"), place.record(RecordKind::Curve, "earlier")];
    let (early_fit, late_fit) = (Arc::new(place.fit(0.25)), Arc::new(place.fit(0.5)));
    let late = place.stored_record(&store, job).await;
    let mut records = vec![late.id];
    for record in early.iter().rev() {
        store.insert_record(job, 1, record.clone(), None).await.unwrap();
        records.push(record.id);
    }
    assert_eq!(store.latest_record(job, 1, RecordKind::Curve).await.unwrap().as_ref(), Some(&*early[0]));
    let mut read = Vec::new();
    let mut after = None;
    for _ in 0..3 {
        let page = store.records(job, 1, PageRequest { limit: 1, after }).await.unwrap();
        read.extend(page.items.iter().map(|record| record.id));
        after = page.next;
    }
    assert_eq!((read, after), (records.clone(), None));
    let trace = store.trace(job, WHOLE).await.unwrap();
    assert_eq!(trace.iterations[0].records.iter().map(|record| record.id).collect::<Vec<_>>(), records);
    // fits likewise
    for fit in [&late_fit, &early_fit] {
        store.insert_fit(job, 1, fit.clone(), None).await.unwrap();
    }
    let fits = store.fits(job, 1, WHOLE).await.unwrap().items;
    assert_eq!(fits.iter().map(|fit| fit.id).collect::<Vec<_>>()[1..], [late_fit.id, early_fit.id]);
    assert_eq!(store.iteration(job, 1).await.unwrap().fits.last().unwrap().id, early_fit.id);
}
