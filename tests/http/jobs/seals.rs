//! Seals as a server makes them: in the database, in its file and over HTTP.

use std::{
    fs,
    path::Path,
    process::Command,
    time::{Duration, Instant},
};

use flankfit::config::ServeSettings;
use serde_json::Value;
use sqlx::{AssertSqlSafe, ConnectOptions as _, sqlite::SqliteConnectOptions};

use super::{app::TestApp, audit::by_python_with};
use crate::{database::in_file, harness};

/// Seals every second, signed, into the file `seals` of the folder.
pub fn sealing(folder: &Path) -> impl FnOnce(&mut ServeSettings) + use<> {
    let (key, file) = (folder.join("key.pem"), folder.join("seals"));
    let pair = rcgen::KeyPair::generate_for(&rcgen::PKCS_ED25519).unwrap();
    fs::write(&key, pair.serialize_pem()).unwrap();
    fs::write(folder.join("public.pem"), pair.public_key_pem()).unwrap();
    move |settings| {
        settings.audit.audit_signing_key = Some(key);
        settings.audit.audit_seal_file = Some(file);
        settings.audit.audit_seal_seconds = 1;
    }
}

/// The lines of a file of seals, once a head of a chain is among them.
pub async fn lines(file: &Path, chain: &str, number: u64) -> Vec<Value> {
    let begun = Instant::now();
    loop {
        let text = fs::read_to_string(file).unwrap_or_default();
        let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let heads = lines.iter().flat_map(|line| line["chains"].as_array().unwrap());
        if heads.into_iter().any(|head| head["chain"] == *chain && head["number"] == number) {
            return lines;
        }
        assert!(begun.elapsed() < Duration::from_secs(30), "{text}");
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
}

#[tokio::test]
async fn a_server_seals_what_was_changed() {
    let folder = tempfile::tempdir().unwrap();
    let (file, change) = (folder.path().join("seals"), sealing(folder.path()));
    let mut app = TestApp::around(harness::TestApp::start_in(folder, change).await);
    let job = app.job().await;
    app.iteration(&job).await;
    let id = job.rsplit('/').next().unwrap();
    let made = lines(&file, id, 2).await;
    let listed = app.get("/v1/audit/seals").await.expect(200).json();
    let answered = listed["items"].as_array().unwrap();
    assert_eq!(answered.len(), made.len());
    for (answered, line) in answered.iter().zip(&made) {
        let mut line = line.as_object().unwrap().clone();
        let chains = line.remove("chains").unwrap();
        assert_eq!(Value::Object(line), *answered);
        assert_eq!(answered["heads"], chains.as_array().unwrap().len());
        assert_eq!(
            (answered["tenant"].as_str(), answered["signature"].as_str().unwrap().len()),
            (Some("default"), 128)
        );
    }
    let head = app.get(&format!("{job}/audit/verify")).await.expect(200).json()["head"].clone();
    let sealed =
        made.iter().flat_map(|line| line["chains"].as_array().unwrap().clone()).find(|head| head["number"] == 2);
    assert_eq!(sealed.unwrap()["sha256"], head);
    // somebody else's program comes to the same, and to another of a chain that was written anew
    let page = app.get(&format!("{job}/audit")).await.expect(200).json();
    let seals = file.display().to_string();
    let by_python = |page: &Value| by_python_with(&["--against", &seals], id, page);
    assert_eq!(by_python(&page), format!("intact 2 {}", head.as_str().unwrap()));
    let mut shorter = page.clone();
    shorter["items"].as_array_mut().unwrap().pop();
    assert_eq!(by_python(&shorter), "2 entry");
    let forged = file.with_file_name("forged").display().to_string();
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&forged, text.replace(head.as_str().unwrap(), &"0".repeat(64))).unwrap();
    let found = by_python_with(&["--against", &forged], id, &page);
    assert!(found.ends_with("is not as it was made"), "{found}");
    let refused = app.get(&format!("/v1/audit/seals?cursor=08{:032}", 1)).await;
    assert_eq!(refused.problem(422, "invalid_request"), ["/cursor"]);
    app.stop().await;
}

/// `flankfit audit verify`, while the server runs: its exit code and what it prints.
fn verified(database: &Path, more: &[&str]) -> (Option<i32>, String, String) {
    let run = Command::new(env!("CARGO_BIN_EXE_flankfit"))
        .args(["audit", "verify", "--database-url", &in_file(database)])
        .args(more)
        .env_clear()
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (run.status.code(), text(run.stdout), text(run.stderr))
}

/// An empty database is new, or its files are gone: "intact" would hide the latter.
#[tokio::test]
async fn an_empty_database_is_called_empty() {
    let folder = tempfile::tempdir().unwrap();
    let database = folder.path().join("test.db");
    let url = in_file(&database);
    let app = harness::TestApp::start_in(folder, |settings| settings.database_url = url).await;
    let (code, said, errors) = verified(&database, &[]);
    assert_eq!(code, Some(0), "{said}{errors}");
    assert!(said.starts_with("empty: there is nothing in this database that was audited"), "{said}");
    app.stop().await;
}

#[tokio::test]
async fn the_command_line_finds_what_was_changed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_owned();
    let (file, database, change) = (path.join("seals"), path.join("test.db"), sealing(&path));
    let url = in_file(&database);
    let start = harness::TestApp::start_in(folder, |settings| {
        change(settings);
        settings.database_url = url;
    });
    let mut app = TestApp::around(start.await);
    let [job, other] = [app.job().await, app.job().await];
    app.iteration(&job).await;
    let [id, other] = [&job, &other].map(|job| job.rsplit('/').next().unwrap().to_owned());
    let made = lines(&file, &id, 2).await;
    // a copy elsewhere; its last line was cut off
    let kept = path.join("kept").display().to_string();
    fs::write(&kept, fs::read_to_string(&file).unwrap() + "{\"tenant\":\"defa").unwrap();
    let public = path.join("public.pem").display().to_string();
    let (code, said, errors) = verified(&database, &["--against", &kept, "--public-key", &public]);
    assert_eq!(code, Some(0), "{said}{errors}");
    assert_eq!(said, format!("intact: 3 chains, 3 entries, {} seals\n", made.len()));
    assert!(errors.contains(&format!("line {} of {kept} is left out", made.len() + 1)), "{errors}");
    assert_eq!(verified(&database, &["--job", &other]).1.split(',').next(), Some("intact: 1 chains"));

    let mut own = SqliteConnectOptions::new().filename(&database).connect().await.unwrap();
    let drop = "DROP TRIGGER audit_no_update; DROP TRIGGER audit_sealed_no_update; DROP TRIGGER nodes_no_update;";
    sqlx::raw_sql(AssertSqlSafe(format!("{drop} UPDATE nodes SET count = count + 1"))).execute(&mut own).await.unwrap();
    let content = format!("broken: job {id} of tenant default, entry 2: content\n");
    for more in [&["--all"][..], &["--job", &id], &["--against", &kept]] {
        let (code, said, _) = verified(&database, more);
        assert_eq!((code, said.as_str()), (Some(1), &*content));
    }
    assert_eq!(verified(&database, &["--job", &other]).0, Some(0));
    let forget = "UPDATE nodes SET count = count - 1; UPDATE audit_sealed SET sha256 = zeroblob(32) WHERE number = 2";
    sqlx::raw_sql(forget).execute(&mut own).await.unwrap();
    let (code, said, _) = verified(&database, &["--all"]);
    let number =
        made.iter().find(|line| line["chains"].to_string().contains("\"number\":2")).unwrap()["number"].clone();
    let seal = format!("broken: seals of tenant default, seal {number}: content\n");
    assert_eq!((code, said), (Some(1), format!("{seal}broken: job {id} of tenant default, entry 2: seal\n")));
    // what was kept counts more than the seals of the database
    assert_eq!(verified(&database, &["--against", &kept]).1, seal);

    // what cannot be found out
    let nowhere = path.join("nowhere").display().to_string();
    let forged = path.join("forged").display().to_string();
    fs::write(&forged, fs::read_to_string(&file).unwrap().replace("\"heads\":", "\"heads\":1")).unwrap();
    for (more, why) in [
        (&["--job", "0190b0de-0000-7000-8000-000000000000"][..], "there is no such job"),
        (&["--against", &nowhere], "cannot read"),
        (&["--against", &public], "no seals in"),
        (&["--against", &forged], "the seal in line 1 of"),
        (&["--public-key", &kept], "no Ed25519 public key"),
        (&["--all", "--job", &id], "cannot be used with"),
    ] {
        let (code, said, errors) = verified(&database, more);
        assert!(code == Some(2) && said.is_empty() && errors.contains(why), "{code:?} {errors}");
    }
    let (code, _, errors) = verified(Path::new(&nowhere), &[]);
    assert!(code == Some(2) && errors.contains("there is no database at"), "{errors}");
    app.stop().await;
}
