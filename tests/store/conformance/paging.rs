//! Pages neither repeat nor skip, whatever comes and goes meanwhile.

use flankfit::jobs::{PageRequest, Precondition};

use super::pair::Pair;

pub async fn pages_are_stable_while_jobs_come_and_go(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let mut created = Vec::new();
    for _ in 0..10 {
        created.push(place.stored_job(&store).await.id);
    }
    let mut seen = Vec::new();
    let mut request = PageRequest { limit: 3, after: None };
    loop {
        let page = store.jobs(request).await.unwrap();
        seen.extend(page.items.iter().map(|job| job.id));
        // New jobs come before the first page; the one the cursor stands on goes away.
        place.stored_job(&store).await;
        let Some(next) = page.next else { break };
        store.delete_job(next.0, Precondition::None).await.unwrap();
        request.after = Some(next);
    }
    created.reverse();
    assert_eq!(seen, created);
}

pub async fn a_full_last_page_has_no_next(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    for _ in 0..4 {
        place.stored_job(&store).await;
    }
    let page = store.jobs(PageRequest { limit: 4, after: None }).await.unwrap();
    assert_eq!((page.items.len(), page.next), (4, None));
    let page = store.jobs(PageRequest { limit: 3, after: None }).await.unwrap();
    assert_eq!(page.next.map(|next| next.0), Some(page.items[2].id));
}
