//! Seals as a server makes them: in the database, in its file and over HTTP.

use std::{
    fs,
    path::Path,
    process::Command,
    time::{Duration, Instant},
};

use flankfit::config::ServeSettings;
use serde_json::{Value, json};
use sqlx::{ConnectOptions as _, sqlite::SqliteConnectOptions};

use super::{
    app::TestApp,
    audit::{by_python_with, verify_of},
    purges::purged,
};
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

/// The lines of a file of seals, once so many entries are sealed.
pub async fn lines(file: &Path, entries: u64) -> Vec<Value> {
    let begun = Instant::now();
    loop {
        let text = fs::read_to_string(file).unwrap_or_default();
        let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        if lines.iter().any(|line| line["last_entry"] == entries) {
            return lines;
        }
        assert!(begun.elapsed() < Duration::from_secs(30), "{text}");
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
}

#[tokio::test]
async fn a_server_seals_changes() {
    let folder = tempfile::tempdir().unwrap();
    let (file, change) = (folder.path().join("seals"), sealing(folder.path()));
    let mut app = TestApp::around(harness::TestApp::start_in(folder, change).await);
    let job = app.job().await;
    app.iteration(&job).await;
    let made = lines(&file, 2).await;
    let listed = app.get("/v1/audit/seals").await.expect(200).json();
    assert_eq!(*listed["items"].as_array().unwrap(), made);
    let last = made.last().unwrap();
    assert_eq!((last["tenant"].as_str(), last["signature"].as_str().unwrap().len()), (Some("default"), 128));
    assert_eq!(app.get(&verify_of(&job)).await.expect(200).json()["unsealed"], 0);
    // somebody else's program comes to the same, and to another of a chain that was written anew
    let page = app.get("/v1/audit").await.expect(200).json();
    let seals = file.display().to_string();
    let by_python = |page: &Value| by_python_with(&["--against", &seals], page);
    let head = last["last_sha256"].as_str().unwrap();
    assert_eq!(by_python(&page), format!("intact 2 {head}"));
    let tampered = |change: fn(&mut Value)| {
        let mut page = page.clone();
        change(&mut page["items"]);
        by_python(&page)
    };
    assert_eq!(tampered(|items| drop(items.as_array_mut().unwrap().pop())), "2 entry");
    assert_eq!(tampered(|items| items[1]["actor"] = json!("other")), "2 entry");
    assert_eq!(tampered(|items| items[0]["contents"]["jobs/1"] = json!("00".repeat(32))), "1 entry");
    assert_eq!(tampered(|items| drop(items.as_array_mut().unwrap().remove(0))), "1 entry");
    let forged = file.with_file_name("forged").display().to_string();
    fs::write(&forged, fs::read_to_string(&file).unwrap().replace(head, &"0".repeat(64))).unwrap();
    let found = by_python_with(&["--against", &forged], &page);
    assert!(found.ends_with("is not as it was made"), "{found}");
    // after a purge nobody has a name any more
    purged(&app, &job).await;
    lines(&file, 3).await;
    let page = app.get("/v1/audit").await.expect(200).json();
    assert_eq!((page["items"][0].get("actor"), &page["items"][2]["actor"]), (None, &json!("anonymous")));
    assert!(by_python(&page).starts_with("intact 3 "), "{}", by_python(&page));
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
async fn the_command_line_detects_changes() {
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
    let made = lines(&file, 3).await;
    let kept = path.join("kept").display().to_string();
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&kept, &text).unwrap();
    let public = path.join("public.pem").display().to_string();
    let (code, said, errors) = verified(&database, &["--against", &kept, "--public-key", &public]);
    assert_eq!(code, Some(0), "{said}{errors}");
    assert!(
        said.starts_with(&format!("intact: 2 jobs, 3 entries, {} seals; 0 entries are not sealed", made.len())),
        "{said}"
    );
    assert!(verified(&database, &["--job", &other]).1.starts_with("intact: 1 jobs, 1 entries, "));
    // the last line of the copy was cut in half
    let cut = path.join("cut").display().to_string();
    fs::write(&cut, &text[..text.len() - 100]).unwrap();
    let (code, said, _) = verified(&database, &["--against", &cut]);
    let spoilt = format!("broken: line {} of {cut} is no seal, or was cut off", made.len());
    assert!(code == Some(1) && said.starts_with(&spoilt), "{said}");

    let mut own = SqliteConnectOptions::new().filename(&database).connect().await.unwrap();
    let change = "DROP TRIGGER nodes_no_update; UPDATE nodes SET count = count + 1";
    sqlx::raw_sql(change).execute(&mut own).await.unwrap();
    let changed = format!("broken: job {id} of tenant default, nodes/1: changed\n");
    for more in [&[][..], &["--job", &id], &["--against", &kept]] {
        let (code, said, _) = verified(&database, more);
        assert_eq!((code, said.as_str()), (Some(1), &*changed));
    }
    assert_eq!(verified(&database, &["--job", &other]).0, Some(0));
    let forget = "UPDATE nodes SET count = count - 1; DROP TRIGGER audit_seals_no_delete; DELETE FROM audit_seals";
    sqlx::raw_sql(forget).execute(&mut own).await.unwrap();
    let (code, said, _) = verified(&database, &["--against", &kept]);
    let missing = format!("broken: tenant default, seal {}: missing\n", made.len());
    assert!(code == Some(1) && said.contains(&missing), "{said}");

    // what cannot be found out
    let nowhere = path.join("nowhere").display().to_string();
    let forged = path.join("forged").display().to_string();
    fs::write(&forged, text.replace("\"last_entry\":", "\"last_entry\":1")).unwrap();
    let empty = path.join("empty").display().to_string();
    fs::write(&empty, "\n").unwrap();
    for (more, why) in [
        (&["--job", "0190b0de-0000-7000-8000-000000000000"][..], "there is no such job"),
        (&["--against", &nowhere], "cannot read"),
        (&["--against", &empty], "no seals in"),
        (&["--against", &forged], "the seal in line 1 of"),
        (&["--public-key", &kept], "no Ed25519 public key"),
    ] {
        let (code, said, errors) = verified(&database, more);
        assert!(code == Some(2) && said.is_empty() && errors.contains(why), "{code:?} {errors}");
    }
    let (code, _, errors) = verified(Path::new(&nowhere), &[]);
    assert!(code == Some(2) && errors.contains("there is no database at"), "{errors}");
    app.stop().await;
}
