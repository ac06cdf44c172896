//! Databases that are opened, and databases that are refused with a message.

use std::{sync::Arc, time::Duration};

use flankfit::{
    jobs::{OrderedIds, SystemClock},
    store::{
        Migrate, OpenError, PostgresError, PostgresSettings, StoreSettings, migrations, open_postgres, open_sqlite,
        postgres_migrations,
    },
};
use sqlx::{Connection as _, PgConnection};

use crate::{
    server::Server,
    support::{Place, still},
};

#[test]
fn both_databases_have_the_same_migrations() {
    let [sqlite, postgres] = [migrations(), postgres_migrations()]
        .map(|all| all.iter().map(|migration| migration.version).collect::<Vec<_>>());
    assert_eq!(sqlite, postgres);
}

/// A database of a development version has another first migration.
const EARLIER: &str = "UPDATE _sqlx_migrations SET checksum = substr(checksum, 1, 8) WHERE version = 1";

#[tokio::test]
async fn a_database_of_an_earlier_version_is_refused_in_words() {
    let place = Place::new();
    place.open().await.close().await;
    let mut own = place.connect().await;
    sqlx::query(EARLIER).execute(&mut own).await.unwrap();
    own.close().await.unwrap();
    let refused = open_sqlite(StoreSettings::of_file(place.file()), still(place.now())).await.err();
    let said = refused.as_ref().map(ToString::to_string).unwrap_or_default();
    assert!(matches!(refused, Some(OpenError::Earlier { .. })) && said.contains("start with a new database"), "{said}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_server_with_a_schema_of_an_earlier_version_is_refused_in_words() {
    let url = Server::shared().database().await;
    let mut own = PgConnection::connect(&url).await.unwrap();
    sqlx::query(EARLIER).execute(&mut own).await.unwrap();
    own.close().await.unwrap();
    for migrate in [Migrate::Auto, Migrate::Check] {
        let mut settings = PostgresSettings::of_url(&url).unwrap();
        (settings.unsafe_store, settings.migrate, settings.patience) = (true, migrate, Duration::from_secs(60));
        let refused = open_postgres(settings, Arc::new(OrderedIds::new()), Arc::new(SystemClock)).await.err();
        assert!(matches!(refused, Some(PostgresError::Earlier { .. })), "{refused:?}");
    }
}

#[tokio::test]
async fn a_newer_database_is_refused_in_words() {
    let place = Place::new();
    place.open().await.close().await;
    let mut own = place.connect().await;
    sqlx::query(
        "INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time)
         VALUES (9999, 'from the future', 1, x'00', 0)",
    )
    .execute(&mut own)
    .await
    .unwrap();
    let refused = open_sqlite(StoreSettings::of_file(place.file()), still(place.now())).await.err();
    assert!(matches!(refused, Some(OpenError::Newer { version: 9999, .. })), "{refused:?}");
}

#[tokio::test]
async fn unopenable_databases_are_explained() {
    let place = Place::new();
    let open = async |settings: StoreSettings| match open_sqlite(settings, still(place.now())).await {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    let nowhere = open(StoreSettings::of_file(place.path("no/such/directory/jobs.db"))).await;
    assert!(nowhere.contains("its directory must exist and be writable"), "{nowhere}");
    std::fs::write(place.file(), "not a database, but long enough to have a header of a hundred bytes ".repeat(20))
        .unwrap();
    let foreign = open(StoreSettings::of_file(place.file())).await;
    assert!(foreign.contains("is not an SQLite database"), "{foreign}");
    assert!(matches!(StoreSettings::of_url("sqlite::memory:"), Err(OpenError::InMemory)));
    assert!(matches!(StoreSettings::of_url("postgres://host/db"), Err(OpenError::Url { .. })));
}
