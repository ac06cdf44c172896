//! Seals of a PostgreSQL database on whose server somebody leaves a transaction open.

use std::sync::Arc;

use flankfit::{
    jobs::{OrderedIds, Store, SystemClock, Upkeep as _, audit::Sealing},
    store::{PostgresSettings, open_postgres},
};
use sqlx::{Connection as _, Executor as _, PgConnection};

use crate::{
    server::Server,
    support::{Values, caller, sealed, verified},
};

/// Committed entries are sealed; those of the open transaction are sealed later.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn an_open_transaction_delays_no_other_entry() {
    let url = Server::shared().database().await;
    let mut settings = PostgresSettings::of_url(&url).unwrap();
    settings.unsafe_store = true;
    let store = open_postgres(settings, Arc::new(OrderedIds::new()), Arc::new(SystemClock)).await.unwrap();
    let store: Arc<dyn Store> = Arc::new(store);
    let (repository, values) = (store.of(&caller("default")), Values::default());
    let mut open = PgConnection::connect(&url).await.unwrap();
    let late = "BEGIN; INSERT INTO audit (id, tenant, at, actor, action, subject, contents, salt, who)
                SELECT gen_random_uuid(), 'default', now(), 'x', 'key.change', '/', '', sha256(''), sha256('')";
    open.execute(late).await.unwrap();
    for number in 1..=3 {
        values.stored_job(&repository).await;
        let seals = sealed(&store, values.now()).await;
        assert_eq!((seals.len(), seals[0].number, seals[0].last.number), (1, number, number));
    }
    open.execute("COMMIT").await.unwrap();
    open.close().await.unwrap();
    let seals = sealed(&store, values.now()).await;
    assert_eq!((seals.len(), seals[0].last.number), (1, 4));
    assert_eq!(sealed(&store, values.now()).await, []);
    // it was made by hand: its actor is not the one of its digest
    let verdict = verified(&store).await;
    let faults: Vec<_> = verdict.differences.iter().map(|fault| fault.place.as_str()).collect();
    assert_eq!((verdict.unsealed, faults), (0, vec!["entry 4"]));
    store.close().await;
    Server::shared().done_with(&url);
}

/// Nobody takes that for a turn in which all was sealed.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_turn_while_another_process_seals_seals_nothing() {
    let url = Server::shared().database().await;
    let mut settings = PostgresSettings::of_url(&url).unwrap();
    settings.unsafe_store = true;
    let store = open_postgres(settings, Arc::new(OrderedIds::new()), Arc::new(SystemClock)).await.unwrap();
    let values = Values::default();
    let mut other = PgConnection::connect(&url).await.unwrap();
    other.execute("SELECT pg_advisory_lock(hashtext('flankfit seals'))").await.unwrap();
    let sealing = Sealing { at: values.now(), key: None };
    assert_eq!(store.seal_audit(sealing.clone()).await.unwrap(), None);
    other.close().await.unwrap();
    while store.seal_audit(sealing.clone()).await.unwrap().is_none() {}
    store.close().await;
    Server::shared().done_with(&url);
}
