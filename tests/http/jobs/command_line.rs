//! `flankfit backup`, and starting where no database can be.

use std::{path::Path, process::Command, sync::Arc};

use flankfit::{
    jobs::{Caller, PageRequest, Store, SystemClock, Tenant, Upkeep},
    store::{StoreSettings, open_sqlite},
};

use super::app::TestApp;

fn url(database: &Path) -> String {
    format!("sqlite://{}", database.display())
}

fn flankfit(arguments: &[&str], database: &Path) -> (bool, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_flankfit"))
        .args(arguments)
        .env_clear()
        .env("FLANKFIT_DATABASE_URL", url(database))
        .output()
        .unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.success(), String::from_utf8(text).unwrap())
}

#[tokio::test]
async fn a_backup_is_made_while_the_service_runs() {
    let mut app = TestApp::start_on_file().await;
    let job = app.job().await;
    app.iteration(&job).await;
    let copy = app.database().with_file_name("copy.db");
    let name = copy.to_str().unwrap();
    let (done, said) = flankfit(&["backup", name], &app.database());
    assert!(done && said.contains("copied to"), "{said}");
    let (done, said) = flankfit(&["backup", name], &app.database());
    assert!(!done && said.contains("overwrites nothing"), "{said}");
    app.iteration(&job).await;

    let store = open_sqlite(StoreSettings::of_file(&copy), Arc::new(SystemClock)).await.unwrap();
    let caller = Caller { tenant: Tenant::default(), actor: "test".into(), origin: Default::default() };
    let id = job.rsplit('/').next().unwrap().parse().unwrap();
    let trace = store.of(&caller).trace(id, PageRequest { limit: 50, after: None }).await.unwrap();
    assert_eq!(trace.iterations.len(), 1);
    store.close().await;
    app.stop().await;
}

#[tokio::test]
async fn a_second_server_on_one_database_is_refused() {
    let mut app = TestApp::start_on_file().await;
    app.job().await;
    let url = url(&app.database());
    for arguments in
        [&["serve", "--bind", "127.0.0.1:0"][..], &["demo", "--exit", "--bind", "127.0.0.1:0", "--database-url", &url]]
    {
        let (arguments, database) = (arguments.iter().map(ToString::to_string).collect::<Vec<_>>(), app.database());
        let run = move || flankfit(&arguments.iter().map(String::as_str).collect::<Vec<_>>(), &database);
        let (served, said) = tokio::task::spawn_blocking(run).await.unwrap();
        assert!(!served && said.contains("another flankfit writes it"), "{said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    }
    app.job().await;
    app.stop().await;
}

#[test]
fn a_database_that_cannot_be_is_explained() {
    let directory = tempfile::tempdir().unwrap();
    let nowhere = directory.path().join("missing/jobs.db");
    let (served, said) = flankfit(&["serve", "--bind", "127.0.0.1:0"], &nowhere);
    assert!(!served && said.contains("directory must exist and be writable"), "{said}");
    let (served, said) = flankfit(&["serve", "--bind", "127.0.0.1:0", "--database-url", "mysql://host"], &nowhere);
    assert!(!served && said.contains("sqlite://FILE: another is of the form postgres://"), "{said}");
}

#[test]
fn missing_databases_and_files_are_reported_in_one_line() {
    let directory = tempfile::tempdir().unwrap();
    let nowhere = directory.path().join("none.db");
    let copy = directory.path().join("copy.db");
    let missing = directory.path().join("request.json");
    for (arguments, parts) in [
        (vec!["backup", copy.to_str().unwrap()], ["there is no database at", "--database-url"]),
        (vec!["export", copy.to_str().unwrap()], ["there is no database at", "none.db"]),
        (vec!["purge", "--older-than", "1"], ["there is no database at", "none.db"]),
        (vec!["audit", "verify"], ["there is no database at", "none.db"]),
        // and what there is nothing to do for
        (vec!["migrate"], ["is for PostgreSQL", "`flankfit serve`"]),
        (vec!["migrate", "--database-url", "none.db"], ["postgres://USER@HOST:PORT/DATABASE", "begins with"]),
        (vec!["fit", missing.to_str().unwrap()], ["cannot read", "name a file that holds a fit request"]),
        (vec!["healthcheck", "--bind", "127.0.0.1:1"], ["no server answers at 127.0.0.1:1", "flankfit serve"]),
    ] {
        let (done, said) = flankfit(&arguments, &nowhere);
        assert!(!done && parts.iter().all(|part| said.contains(part)), "{said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    }
    assert!(!nowhere.exists() && !copy.exists());
    let (done, said) = flankfit(&["healthcheck", "--bind", "8080"], &nowhere);
    assert!(!done && said.contains("localhost:8080"), "{said}");
}

/// A backup of PostgreSQL is refused with a hint.
#[test]
fn postgresql_is_backed_up_by_its_own_means() {
    let directory = tempfile::tempdir().unwrap();
    let copy = directory.path().join("copy.db");
    let url = "postgres://owner:hidden@127.0.0.1:1/jobs";
    let (done, said) = flankfit(&["backup", copy.to_str().unwrap(), "--database-url", url], &copy);
    assert!(!done && !copy.exists());
    let topics = ["pg_basebackup", "write-ahead log", "point-in-time recovery", "pg_dump"];
    assert!(topics.iter().all(|part| said.contains(part)) && !said.contains("hidden"), "{said}");
    assert_eq!(said.trim_end().lines().count(), 1, "{said}");
}

/// Says where it listens before it would go on; the test takes its life then.
#[test]
fn a_host_name_is_a_bind_address_and_keys_may_be_empty() {
    use std::io::{BufRead, BufReader};
    let directory = tempfile::tempdir().unwrap();
    let mut server = Command::new(env!("CARGO_BIN_EXE_flankfit"))
        .args(["serve", "--bind", "localhost:0"])
        .env_clear()
        .env("FLANKFIT_DATABASE_URL", format!("sqlite://{}", directory.path().join("jobs.db").display()))
        .env("FLANKFIT_API_KEYS_SHA256", "")
        .env("FLANKFIT_LOG_FORMAT", "json")
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(server.stderr.take().unwrap()).lines().map_while(Result::ok);
    let address = lines.filter_map(|line| serde_json::from_str::<serde_json::Value>(&line).ok()).find_map(|line| {
        let message = line.to_string();
        let from = message.find("http://")? + "http://".len();
        Some(message[from..].split([',', '/', '"']).next()?.to_owned())
    });
    let (healthy, said) =
        flankfit(&["healthcheck", "--bind", address.as_deref().unwrap_or_default()], directory.path());
    server.kill().unwrap();
    server.wait().unwrap();
    assert!(healthy, "{address:?}: {said}");
}
