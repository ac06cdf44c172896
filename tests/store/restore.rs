//! A base backup of PostgreSQL and the log since: what comes back is what was there, and its audit
//! holds.

use std::{fs, process::Command, sync::Arc};

use flankfit::{
    jobs::{Repository, Store, SystemClock},
    store::{PostgresSettings, open_postgres},
};
use sqlx::{Connection as _, PgConnection};
use uuid::Uuid;

use crate::{
    server::{Server, shell},
    support::{Values, archived, caller, ids, purge_of, sealed},
};

/// Makes the server keep its log in a folder next to it. (A new cluster lets everybody replicate
/// from here; a line for all databases does not.)
const KEEP_LOG: &str = "mkdir log-kept && grep -v replication data/pg_hba.conf >hba && \
    echo 'local replication flankfit_backup,flankfit_owner trust' >>hba && cp hba data/pg_hba.conf && \
    printf \"archive_mode=on\\narchive_command='cp %%p $PWD/log-kept/%%f'\\n\" >>data/postgresql.conf && \
    $BIN/pg_ctl -D data -l log -m fast -w restart";
/// Role of docs/how-to/postgresql.md.
const ROLE: &str = "CREATE ROLE flankfit_backup LOGIN REPLICATION";
const BACKUP: &str = "$BIN/pg_basebackup -h \"$PWD\" -U flankfit_backup -D copy -X none -c fast --no-sync";
/// Ends the server as the loss of its machine would, and brings the copy up to the end of the log.
const RESTORE: &str = "$BIN/pg_ctl -D data -m immediate -w stop && \
    printf \"restore_command='cp $PWD/log-kept/%%f %%p'\\narchive_mode=off\\nhot_standby=off\\n\" >>copy/postgresql.conf && \
    touch copy/recovery.signal && chmod 700 copy && mv data lost && mv copy data && \
    $BIN/pg_ctl -D data -l log -w -t 120 start";

/// Runs a script in the folder of a server.
pub fn run(server: &Server, script: &str) {
    let done = shell(&server.folder, script).status().unwrap();
    assert!(done.success(), "{script}: {}", fs::read_to_string(server.folder.join("log")).unwrap_or_default());
}

/// The program says so, which has nothing but the database.
pub fn verified(url: &str) -> String {
    let run = Command::new(env!("CARGO_BIN_EXE_flankfit"))
        .args(["audit", "verify", "--database-url", url])
        .env_clear()
        .output()
        .unwrap();
    let printed = String::from_utf8([run.stdout, run.stderr].concat()).unwrap();
    assert!(run.status.success(), "{printed}");
    printed
}

async fn open(url: &str) -> Arc<dyn Store> {
    let mut settings = PostgresSettings::of_url(url).unwrap();
    settings.unsafe_store = true;
    Arc::new(open_postgres(settings, ids(), Arc::new(SystemClock)).await.unwrap())
}

async fn purged(store: &Arc<dyn Store>, place: &Values) -> Uuid {
    let repository: Arc<dyn Repository> = store.of(&caller("default"));
    let job = place.stored_job(&repository).await.id;
    place.stored_iteration(&repository, job).await;
    repository.purge_job(purge_of(place, job), None).await.unwrap();
    job
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_base_backup_and_the_log_since_bring_everything_back() {
    let server = Server::start();
    run(&server, KEEP_LOG);
    let url = server.database().await;
    let (store, place) = (open(&url).await, Values::default());
    let repository = store.of(&caller("default"));
    let first = place.stored_job(&repository).await.id;
    place.stored_iteration(&repository, first).await;
    purged(&store, &place).await;
    assert_eq!(sealed(&store, place.now()).await.len(), 1);
    // its rights are enough, and no others than that
    assert!(include_str!("../../docs/how-to/postgresql.md").contains(&format!("    {ROLE};\n")));
    let mut own = PgConnection::connect(&server.url("postgres")).await.unwrap();
    sqlx::query("CREATE ROLE flankfit_owner LOGIN").execute(&mut own).await.unwrap();
    sqlx::query(ROLE).execute(&mut own).await.unwrap();
    drop(own);
    let refused = shell(&server.folder, &BACKUP.replace("flankfit_backup", "flankfit_owner")).status().unwrap();
    assert!(!refused.success());
    run(&server, BACKUP);

    // what comes after the backup is in the log alone
    place.stored_iteration(&repository, first).await;
    let second = place.stored_job(&repository).await.id;
    place.stored_iteration(&repository, second).await;
    let gone = purged(&store, &place).await;
    let before: Vec<_> = {
        let mut all = Vec::new();
        for job in [first, second, gone] {
            all.push(archived(&store, "default", job).await);
        }
        all
    };
    let said = verified(&url);
    store.close().await;
    let mut own = PgConnection::connect(&server.url("postgres")).await.unwrap();
    sqlx::query("SELECT pg_switch_wal()").execute(&mut own).await.unwrap();
    // the last piece of the log is kept when the server says so
    for attempt in 0.. {
        let kept: bool = sqlx::query_scalar(
            "SELECT coalesce(last_archived_wal >= pg_walfile_name(pg_current_wal_lsn() - 1), false) FROM pg_stat_archiver",
        )
        .fetch_one(&mut own)
        .await
        .unwrap();
        if kept {
            break;
        }
        // where nobody wakes it, the server looks once a minute
        assert!(attempt < 2400, "the log is not kept");
        tokio::time::sleep(std::time::Duration::from_millis(50)).await;
    }
    drop(own);
    run(&server, RESTORE);

    assert_eq!(verified(&url), said);
    let store = open(&url).await;
    for (job, before) in [first, second, gone].into_iter().zip(before) {
        assert_eq!(archived(&store, "default", job).await, before);
    }
    // and it goes on
    place.stored_iteration(&store.of(&caller("default")), first).await;
    assert_eq!(sealed(&store, place.now()).await.len(), 1);
    store.close().await;
    assert!(verified(&url).starts_with("intact: "));
}
