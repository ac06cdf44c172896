//! Seals of a PostgreSQL database on whose server somebody leaves a transaction open.

use std::{sync::Arc, time::Duration};

use flankfit::{
    jobs::{
        OrderedIds, Store as _, SystemClock, Upkeep as _,
        audit::{Sealing, WholeSeal},
    },
    store::{PostgresSettings, SqlStore, open_postgres},
};
use jiff::Timestamp;
use sqlx::{Connection as _, Executor as _, PgConnection};
use tokio::time::{Instant, sleep};

use crate::{
    server::Server,
    support::{Values, caller},
};

/// What others began on the server of the tests has ended by then.
const PATIENCE: Duration = Duration::from_secs(60);

async fn sealed(store: &SqlStore, values: &Values) -> Vec<WholeSeal> {
    let sealing = Sealing { at: values.now(), key: None, unless_since: Timestamp::MAX };
    store.seal_audit(sealing).await.unwrap().unwrap_or_default()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn an_open_transaction_leaves_entries_unsealed_and_told() {
    let url = Server::shared().database().await;
    let mut settings = PostgresSettings::of_url(&url).unwrap();
    settings.unsafe_store = true;
    let store = open_postgres(settings, Arc::new(OrderedIds::new()), Arc::new(SystemClock)).await.unwrap();
    let (repository, values) = (store.of(&caller("default")), Values::default());
    let mut open = PgConnection::connect(&url).await.unwrap();
    open.execute("BEGIN; SELECT pg_current_xact_id()").await.unwrap();
    values.stored_job(&repository).await;
    let held = store.unsealed().await.unwrap().oldest;
    assert!(held.is_some());
    for _ in 0..3 {
        assert_eq!(sealed(&store, &values).await, []);
        values.stored_job(&repository).await;
        assert_eq!(store.unsealed().await.unwrap().oldest, held);
    }
    open.execute("COMMIT").await.unwrap();
    let begun = Instant::now();
    while store.unsealed().await.unwrap().oldest.is_some() {
        assert!(begun.elapsed() < PATIENCE, "{:?}", store.unsealed().await);
        sealed(&store, &values).await;
        sleep(Duration::from_millis(20)).await;
    }
    open.close().await.unwrap();
    store.close().await;
    Server::shared().done_with(&url);
}
