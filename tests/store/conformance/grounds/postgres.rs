//! PostgreSQL: a database of its own on the server of the tests, on which every handle is a store
//! of its own, as those of two processes are.

use std::{sync::Arc, time::Duration};

use flankfit::{
    jobs::{OrderedIds, Store, SystemClock},
    store::{PostgresSettings, open_postgres},
};
use sqlx::{AssertSqlSafe, Connection, PgConnection};
use tokio::sync::OnceCell;
use uuid::Uuid;

use crate::{
    conformance::{
        grounds::hex,
        pair::{Ground, Soon},
    },
    server::Server,
};

pub struct Postgres {
    url: String,
}

/// A new database.
pub async fn postgres() -> Postgres {
    Postgres { url: Server::shared().database().await }
}

/// A migration that this version does not know: columns in every table, and a table.
const NEXT: &str = "
    DO $$ DECLARE every regclass; BEGIN
        FOR every IN SELECT oid FROM pg_class
            WHERE relkind IN ('r', 'p') AND NOT relispartition AND relnamespace = current_schema()::regnamespace
                  AND relname <> '_sqlx_migrations'
        LOOP
            EXECUTE format('ALTER TABLE %s ADD of_the_next text, ADD counted bigint NOT NULL DEFAULT 0', every);
        END LOOP;
    END $$;
    CREATE TABLE of_the_next_version (job uuid PRIMARY KEY, told text NOT NULL);
    INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time)
    VALUES (1000, 'the next version', true, '', 0)";

/// One that the next version has been to, as while replicas are replaced one by one.
pub async fn after_next_version() -> Postgres {
    static TEMPLATE: OnceCell<String> = OnceCell::const_new();
    let server = Server::shared();
    let template = TEMPLATE
        .get_or_init(|| async {
            let name = server.with_schema().await;
            let mut db = PgConnection::connect(&server.url(&name)).await.unwrap();
            sqlx::raw_sql(NEXT).execute(&mut db).await.unwrap();
            db.close().await.unwrap();
            name
        })
        .await;
    Postgres { url: server.url(&server.copy_of(template).await) }
}

impl Drop for Postgres {
    fn drop(&mut self) {
        Server::shared().done_with(&self.url);
    }
}

impl Postgres {
    async fn opened(&self, settings: PostgresSettings) -> Arc<dyn Store> {
        let (ids, clock) = (Arc::new(OrderedIds::new()), Arc::new(SystemClock));
        Arc::new(open_postgres(settings, ids, clock).await.unwrap())
    }

    fn settings(&self) -> PostgresSettings {
        let mut settings = PostgresSettings::of_url(&self.url).unwrap();
        (settings.readers, settings.writers) = (2, 2);
        // the server is that of many tests at once
        settings.patience = Duration::from_secs(60);
        // the server of the tests syncs nothing
        settings.unsafe_store = true;
        settings
    }
}

impl Ground for Postgres {
    fn open(&self) -> Soon<'_, Arc<dyn Store>> {
        Box::pin(self.opened(self.settings()))
    }

    fn open_narrow(&self, places: usize) -> Soon<'_, Arc<dyn Store>> {
        let mut settings = self.settings();
        settings.queue = places;
        Box::pin(self.opened(settings))
    }

    fn closed(&self) -> Soon<'_, ()> {
        Box::pin(async {})
    }

    fn intrude(&self, sql: String) -> Soon<'_, ()> {
        Box::pin(async move {
            let mut own = PgConnection::connect(&self.url).await.unwrap();
            let all = format!("SET session_replication_role = replica; {sql}");
            sqlx::raw_sql(AssertSqlSafe(all)).execute(&mut own).await.unwrap();
            own.close().await.unwrap();
        })
    }

    fn settled(&self) -> Soon<'_, ()> {
        Box::pin(async move {
            let mut own = PgConnection::connect(&self.url).await.unwrap();
            let wait = "DO $$ DECLARE now xid8 := pg_snapshot_xmax(pg_current_snapshot());
                        BEGIN
                            WHILE pg_snapshot_xmin(pg_current_snapshot()) < now LOOP PERFORM pg_sleep(0.005); END LOOP;
                        END $$";
            sqlx::raw_sql(wait).execute(&mut own).await.unwrap();
            own.close().await.unwrap();
        })
    }

    fn refusal(&self, sql: &'static str) -> Soon<'_, Option<String>> {
        Box::pin(async move {
            let mut own = PgConnection::connect(&self.url).await.unwrap();
            let outcome = sqlx::query(AssertSqlSafe(sql)).execute(&mut own).await;
            own.close().await.unwrap();
            outcome.err().map(|error| error.to_string())
        })
    }

    fn truncates(&self) -> bool {
        true
    }

    fn refuse_entries(&self, refused: bool) -> Soon<'_, ()> {
        let sql = match refused {
            true => {
                "CREATE FUNCTION no_entry() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
                     RAISE EXCEPTION 'no entry';
                 END $$;
                 CREATE TRIGGER no_entry BEFORE INSERT ON audit FOR EACH ROW EXECUTE FUNCTION no_entry()"
            }
            false => "DROP TRIGGER no_entry ON audit; DROP FUNCTION no_entry()",
        };
        Box::pin(async move {
            let mut own = PgConnection::connect(&self.url).await.unwrap();
            sqlx::raw_sql(sql).execute(&mut own).await.unwrap();
            own.close().await.unwrap();
        })
    }

    fn defenceless(&self) -> Soon<'_, ()> {
        Box::pin(async move {
            let mut own = PgConnection::connect(&self.url).await.unwrap();
            // triggers sleep while it intrudes
            let unchecked = "DO $$ DECLARE c record; BEGIN
                FOR c IN SELECT conrelid::regclass AS of, conname FROM pg_constraint
                         WHERE contype = 'c' AND conrelid <> 0 LOOP
                    EXECUTE format('ALTER TABLE %s DROP CONSTRAINT %I', c.of, c.conname);
                END LOOP; DROP INDEX api_keys_one_for_each_san; END $$";
            sqlx::raw_sql(unchecked).execute(&mut own).await.unwrap();
            own.close().await.unwrap();
        })
    }

    fn columns(&self) -> Soon<'_, Vec<(String, String, String)>> {
        Box::pin(async move {
            let mut own = PgConnection::connect(&self.url).await.unwrap();
            let sql = "SELECT c.table_name::text, c.column_name::text, c.data_type::text
                       FROM information_schema.columns c
                            JOIN information_schema.tables t USING (table_schema, table_name)
                       WHERE c.table_schema = 'public' AND t.table_type = 'BASE TABLE'";
            let columns = sqlx::query_as(sql).fetch_all(&mut own).await.unwrap();
            own.close().await.unwrap();
            columns
        })
    }

    fn changed(&self, column: &str, kind: &str) -> String {
        match kind {
            "bigint" | "double precision" => format!("coalesce({column}, 0) + 1000"),
            "boolean" => format!("NOT {column}"),
            "timestamp with time zone" => format!("coalesce({column}, 'epoch') + interval '1 year'"),
            "text" => format!("coalesce({column}, '') || 'x'"),
            "uuid" => format!("md5(coalesce({column}::text, ''))::uuid"),
            "bytea" => {
                format!("'\\xff'::bytea || substr(coalesce({column}, ''), 1, greatest(0, length({column}) - 1))")
            }
            other => panic!("a column of the type {other}"),
        }
    }

    fn holds<'a>(&'a self, text: &'a str) -> Soon<'a, bool> {
        Box::pin(async move {
            let mut own = PgConnection::connect(&self.url).await.unwrap();
            let tables: Vec<String> =
                sqlx::query_scalar("SELECT tablename::text FROM pg_tables WHERE schemaname = 'public'")
                    .fetch_all(&mut own)
                    .await
                    .unwrap();
            assert!(tables.len() > 15, "{tables:?}");
            let mut found = false;
            for table in tables {
                // documents are bytes, which a row shows in hexadecimal digits
                let sql = format!(
                    "SELECT EXISTS (SELECT FROM {table} AS r WHERE strpos(r::text, $1) > 0
                     OR strpos(r::text, encode(convert_to($1, 'UTF8'), 'hex')) > 0)"
                );
                found |=
                    sqlx::query_scalar::<_, bool>(AssertSqlSafe(sql)).bind(text).fetch_one(&mut own).await.unwrap();
            }
            own.close().await.unwrap();
            found
        })
    }

    fn literal(&self, bytes: &[u8]) -> String {
        format!("'\\x{}'::bytea", hex(bytes))
    }

    fn id(&self, id: Uuid) -> String {
        format!("'{id}'")
    }
}
