//! SQLite: one process has one open store, and every handle is on that.

use std::sync::Arc;

use flankfit::{
    jobs::{Store, Upkeep},
    store::{SqliteStore, StoreSettings},
};
use sqlx::{AssertSqlSafe, Connection};
use tokio::sync::Mutex;

use crate::{
    conformance::pair::{Ground, Soon},
    support::Place,
};

pub struct Sqlite {
    place: Place,
    store: Mutex<Option<Arc<SqliteStore>>>,
}

pub fn sqlite() -> Sqlite {
    Sqlite { place: Place::new(), store: Mutex::default() }
}

impl Ground for Sqlite {
    fn open(&self) -> Soon<'_, Arc<dyn Store>> {
        Box::pin(async {
            let mut open = self.store.lock().await;
            if let Some(store) = &*open {
                return store.clone() as Arc<dyn Store>;
            }
            let settings = StoreSettings::of_file(self.place.file());
            let store = Arc::new(SqliteStore::open(settings, self.place.now()).await.unwrap());
            *open = Some(store.clone());
            store
        })
    }

    fn close(&self) -> Soon<'_, ()> {
        Box::pin(async {
            if let Some(store) = self.store.lock().await.take() {
                store.close().await;
            }
        })
    }

    fn refusal(&self, sql: &'static str) -> Soon<'_, Option<String>> {
        Box::pin(async move {
            let mut own = self.place.connect().await;
            let outcome = sqlx::query(AssertSqlSafe(sql)).execute(&mut own).await;
            own.close().await.unwrap();
            outcome.err().map(|error| error.to_string())
        })
    }
}
