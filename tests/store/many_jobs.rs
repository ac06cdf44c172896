//! One tenant searches all its jobs continuously; another tenant's writes go on. Times are printed.
//!
//!     cargo test --release --test store many_jobs -- --ignored --nocapture

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering::Relaxed},
    },
    time::{Duration, Instant},
};

use flankfit::{
    jobs::{JobFilter, JobQuery, OrderedIds, Repository, Store, SystemClock},
    store::{PostgresSettings, open_postgres},
};
use futures_util::{StreamExt as _, stream};

use crate::{
    server::Server,
    support::{Place, Values, all_jobs, caller},
};

const JOBS: usize = 100_000;
/// Concurrent searches of one tenant.
const AT_A_TIME: usize = 16;
const STORED: usize = 200;

/// Returns the median time of storing another tenant's job.
async fn median(store: &Arc<dyn Repository>, values: &Values) -> Duration {
    let mut times = Vec::new();
    for _ in 0..STORED {
        let job = values.job("other");
        let begun = Instant::now();
        store.insert_job(job, None).await.unwrap();
        times.push(begun.elapsed());
    }
    times.sort_unstable();
    times[STORED / 2]
}

async fn check(kind: &str, store: Arc<dyn Store>, values: &Values) {
    let (greedy, other) = (store.of(&caller("greedy")), store.of(&caller("other")));
    let jobs = (0..JOBS).map(|number| values.job(&format!("Planet wheel {number:06} of the pitch drive")));
    stream::iter(jobs)
        .map(|job| greedy.insert_job(job, None))
        .buffer_unordered(1000)
        .for_each(async |stored| _ = stored.unwrap())
        .await;
    let quiet = median(&other, values).await;
    for (text, tag) in [("zzzz", None), ("zz", None), ("pitch drive zz", None), ("", Some("shift:never"))] {
        let filter = JobFilter {
            text: Some(text.to_owned()).filter(|text| !text.is_empty()),
            tag: tag.map(str::to_owned),
            ..JobFilter::default()
        };
        let query = JobQuery { filter, limit: 50, ..all_jobs() };
        let (stopped, answered) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU64::new(0)));
        let searching: Vec<_> = (0..AT_A_TIME)
            .map(|_| {
                let (greedy, query, stopped, answered) =
                    (greedy.clone(), query.clone(), stopped.clone(), answered.clone());
                tokio::spawn(async move {
                    while !stopped.load(Relaxed) {
                        assert!(greedy.jobs(query.clone()).await.unwrap().items.is_empty());
                        answered.fetch_add(1, Relaxed);
                    }
                })
            })
            .collect();
        let begun = Instant::now();
        let busy = median(&other, values).await;
        stopped.store(true, Relaxed);
        let each_second = answered.load(Relaxed) as f64 / begun.elapsed().as_secs_f64();
        for search in searching {
            search.await.unwrap();
        }
        println!("{kind}, {text:?} {tag:?}: {quiet:.1?} quiet, {busy:.1?} during {each_second:.0} searches/s");
        assert!(answered.load(Relaxed) > 0, "{kind}: no search for {text:?} {tag:?} was answered");
    }
    store.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "it takes minutes"]
async fn a_tenant_that_searches_100_000_jobs_holds_up_no_other_in_sqlite() {
    let place = Place::new();
    let store = place.open().await;
    check("sqlite", store.store.clone(), &place).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "it takes minutes"]
async fn a_tenant_that_searches_100_000_jobs_holds_up_no_other_in_postgres() {
    let mut settings = PostgresSettings::of_url(&Server::shared().database().await).unwrap();
    settings.unsafe_store = true;
    let store = open_postgres(settings, Arc::new(OrderedIds::new()), Arc::new(SystemClock)).await.unwrap();
    check("postgres", Arc::new(store), &Values::default()).await;
}
