//! `flankfit backup`, and starting where no database can be.

use std::{path::Path, process::Command};

use flankfit::store::{Store, StoreSettings};

use super::app::TestApp;

fn flankfit(arguments: &[&str], database: &Path) -> (bool, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_flankfit"))
        .args(arguments)
        .env_clear()
        .env("FLANKFIT_DATABASE_URL", format!("sqlite://{}", database.display()))
        .output()
        .unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.success(), String::from_utf8(text).unwrap())
}

#[tokio::test]
async fn a_backup_is_made_while_the_service_runs() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    app.iteration(&job).await;
    let copy = app.database().with_file_name("copy.db");
    let name = copy.to_str().unwrap();
    let (done, said) = flankfit(&["backup", name], &app.database());
    assert!(done && said.contains("copied to"), "{said}");
    let (done, said) = flankfit(&["backup", name], &app.database());
    assert!(!done && said.contains("overwrites nothing"), "{said}");
    app.iteration(&job).await;

    let store = Store::open(StoreSettings::of_file(&copy), jiff::Timestamp::UNIX_EPOCH).await.unwrap();
    let id = job.rsplit('/').next().unwrap().parse().unwrap();
    let trace = flankfit::jobs::Repository::trace(&store, id).await.unwrap();
    assert_eq!(trace.iterations.len(), 1);
    store.close().await;
    app.stop().await;
}

#[test]
fn a_database_that_cannot_be_is_explained() {
    let directory = tempfile::tempdir().unwrap();
    let nowhere = directory.path().join("missing/jobs.db");
    let (served, said) = flankfit(&["serve", "--bind", "127.0.0.1:0"], &nowhere);
    assert!(!served && said.contains("directory must exist and be writable"), "{said}");
    let (served, said) = flankfit(&["serve", "--bind", "127.0.0.1:0", "--database-url", "mysql://host"], &nowhere);
    assert!(!served && said.contains("keeps its jobs in SQLite"), "{said}");
}
