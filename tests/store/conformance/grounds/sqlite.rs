//! SQLite: one process has one open store, and every handle is on that.

use std::sync::Arc;

use flankfit::{
    jobs::Store,
    store::{StoreSettings, open_sqlite},
};
use sqlx::{AssertSqlSafe, Connection};
use tokio::sync::Mutex;
use uuid::Uuid;

use crate::{
    conformance::{
        grounds::hex,
        pair::{Ground, Soon},
    },
    support::{Place, still},
};

pub struct Sqlite {
    place: Place,
    store: Mutex<Option<Arc<dyn Store>>>,
}

pub async fn sqlite() -> Sqlite {
    Sqlite { place: Place::new(), store: Mutex::default() }
}

impl Sqlite {
    async fn opened(&self, settings: StoreSettings) -> Arc<dyn Store> {
        let mut open = self.store.lock().await;
        if let Some(store) = &*open {
            return store.clone();
        }
        let store: Arc<dyn Store> = Arc::new(open_sqlite(settings, still(self.place.now())).await.unwrap());
        *open = Some(store.clone());
        store
    }
}

impl Ground for Sqlite {
    fn open(&self) -> Soon<'_, Arc<dyn Store>> {
        Box::pin(self.opened(StoreSettings::of_file(self.place.file())))
    }

    fn open_narrow(&self, places: usize) -> Soon<'_, Arc<dyn Store>> {
        let mut settings = StoreSettings::of_file(self.place.file());
        settings.queue = places;
        Box::pin(self.opened(settings))
    }

    fn closed(&self) -> Soon<'_, ()> {
        Box::pin(async { *self.store.lock().await = None })
    }

    fn intrude(&self, sql: String) -> Soon<'_, ()> {
        Box::pin(async move {
            let mut own = self.place.connect().await;
            let triggers = "SELECT name FROM sqlite_schema WHERE type = 'trigger' AND sql LIKE '%RAISE%'";
            let triggers: Vec<String> = sqlx::query_scalar(triggers).fetch_all(&mut own).await.unwrap();
            let drop: String = triggers.iter().map(|name| format!("DROP TRIGGER {name};")).collect();
            let all = format!("PRAGMA foreign_keys = OFF; PRAGMA ignore_check_constraints = ON; {drop} {sql}");
            sqlx::raw_sql(AssertSqlSafe(all)).execute(&mut own).await.unwrap();
            own.close().await.unwrap();
        })
    }

    fn settled(&self) -> Soon<'_, ()> {
        Box::pin(async {})
    }

    fn refusal(&self, sql: &'static str) -> Soon<'_, Option<String>> {
        Box::pin(async move {
            let mut own = self.place.connect().await;
            let outcome = sqlx::query(AssertSqlSafe(sql)).execute(&mut own).await;
            own.close().await.unwrap();
            outcome.err().map(|error| error.to_string())
        })
    }

    fn truncates(&self) -> bool {
        false
    }

    fn refuse_entries(&self, refused: bool) -> Soon<'_, ()> {
        let sql = match refused {
            true => "CREATE TRIGGER no_entry BEFORE INSERT ON audit BEGIN SELECT RAISE (ABORT, 'no entry'); END",
            false => "DROP TRIGGER no_entry",
        };
        Box::pin(async move {
            let mut own = self.place.connect().await;
            sqlx::raw_sql(sql).execute(&mut own).await.unwrap();
            own.close().await.unwrap();
        })
    }

    fn defenceless(&self) -> Soon<'_, ()> {
        Box::pin(async move {
            let mut own = self.place.connect().await;
            let triggers = "SELECT name FROM sqlite_schema WHERE type = 'trigger'";
            let triggers: Vec<String> = sqlx::query_scalar(triggers).fetch_all(&mut own).await.unwrap();
            let drop: String = triggers.iter().map(|name| format!("DROP TRIGGER {name};")).collect();
            let all = format!("{drop} DROP INDEX api_keys_one_for_each_san");
            sqlx::raw_sql(AssertSqlSafe(all)).execute(&mut own).await.unwrap();
            own.close().await.unwrap();
        })
    }

    fn columns(&self) -> Soon<'_, Vec<(String, String, String)>> {
        Box::pin(async move {
            let mut own = self.place.connect().await;
            let sql = "SELECT m.name, p.name, p.type FROM sqlite_schema m JOIN pragma_table_info(m.name) p
                       WHERE m.type = 'table'";
            let columns = sqlx::query_as(sql).fetch_all(&mut own).await.unwrap();
            own.close().await.unwrap();
            columns
        })
    }

    fn changed(&self, column: &str, kind: &str) -> String {
        match kind {
            "INTEGER" | "REAL" => format!("coalesce({column}, 0) + 1000"),
            "TEXT" if column == "at" || column.ends_with("_at") => {
                format!("coalesce('2027' || substr({column}, 5), '2027-01-01T00:00:00.000000Z')")
            }
            "TEXT" => format!("coalesce({column}, '') || 'x'"),
            "BLOB" => {
                format!("coalesce(unhex(substr('FF' || hex({column}), 1, max(2, length(hex({column}))))), x'FF')")
            }
            other => panic!("a column of the type {other}"),
        }
    }

    /// True if the text is in the file, or in its log.
    fn holds<'a>(&'a self, text: &'a str) -> Soon<'a, bool> {
        Box::pin(async move {
            [self.place.file(), self.place.path("jobs.db-wal")].into_iter().any(|file| {
                let bytes = std::fs::read(file).unwrap_or_default();
                bytes.windows(text.len()).any(|piece| piece == text.as_bytes())
            })
        })
    }

    fn literal(&self, bytes: &[u8]) -> String {
        format!("x'{}'", hex(bytes))
    }

    fn id(&self, id: Uuid) -> String {
        self.literal(id.as_bytes())
    }
}
