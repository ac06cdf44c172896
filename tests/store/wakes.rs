//! Notifications of commits between servers.

use std::{
    collections::BTreeSet,
    sync::Arc,
    time::{Duration, Instant},
};

use flankfit::{
    jobs::{OrderedIds, Owned, Store as _, SystemClock, Tenant, Upkeep as _, Wake},
    store::{PostgresSettings, open_postgres},
};
use sqlx::postgres::PgListener;
use tokio::time::timeout;

use crate::{
    server::Server,
    support::{Values, caller},
};

/// The least time between two notifications of a server.
const GATHERING: Duration = Duration::from_millis(10);
/// Commits one after the other, with a notification each.
const COMMITS: usize = 400;

/// A notification for each commit would have commits wait for each other.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn notifications_of_many_commits_are_batched() {
    let url = Server::shared().database().await;
    let mut settings = PostgresSettings::of_url(&url).unwrap();
    settings.unsafe_store = true;
    let store = open_postgres(settings, Arc::new(OrderedIds::new()), Arc::new(SystemClock)).await.unwrap();
    let (repository, values) = (store.of(&caller("default")), Values::default());
    let wakes = store.wakes().expect("one of several");
    let mut listener = PgListener::connect(&url).await.unwrap();
    listener.listen("flankfit").await.unwrap();
    let begun = Instant::now();
    let commits = async {
        let mut stored = BTreeSet::new();
        for _ in 0..COMMITS {
            let job = values.stored_job(&repository).await.id;
            wakes.send(Wake::Job(Owned { tenant: Tenant::default(), id: job }));
            stored.insert(job.simple().to_string());
        }
        (stored, begun.elapsed())
    };
    let hearing = async {
        let (mut heard, mut notifications) = (BTreeSet::new(), 0_u128);
        while heard.len() < COMMITS {
            let notification = timeout(Duration::from_secs(60), listener.recv()).await.expect("the rest arrives");
            let notification = notification.unwrap();
            notifications += 1;
            let words = notification.payload().split(' ').filter_map(|word| word.split_once('/'));
            heard.extend(words.map(|(_, id)| id.to_owned()));
        }
        (heard, notifications, begun.elapsed())
    };
    let ring = |_: Wake| {};
    let ((stored, storing), (heard, notifications, hearing)) = tokio::select! {
        () = wakes.pass_on(&ring) => panic!("it is passed on for ever"),
        all = async { tokio::join!(commits, hearing) } => all,
    };
    assert_eq!(heard, stored, "every commit is notified");
    println!("{COMMITS} commits in {storing:?}, {notifications} notifications in {hearing:?}");
    // one at once; and where much waits it does not fit into one, but into three
    let most = hearing.as_millis() / GATHERING.as_millis() + 3;
    assert!(notifications <= most, "{notifications} notifications in {hearing:?}");
    store.close().await;
}
