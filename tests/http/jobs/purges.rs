//! Jobs that are archived and purged: what is left, what is 410, and that nothing of people stays.

use std::{fs, path::Path, process::Command};

use flankfit::api::jobs::purge::PurgeBody;
use reqwest::Method;
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};

use super::{
    app::{Answer, TestApp, iteration, nodes, send},
    long::trimmed,
};

pub const NOBODY: &str = "/v1/jobs/0190b0de-0000-7000-8000-000000000000";

/// The archive of a job, and its digest as it is told.
pub async fn archived(app: &TestApp, job: &str) -> (Vec<u8>, String) {
    let response = app.request(Method::POST, &format!("{job}/archive")).send().await.unwrap();
    assert_eq!(response.status(), 200);
    let header = |name: &str| response.headers()[name].to_str().unwrap().to_owned();
    let (told, length) = (header("archive-sha256"), header("content-length"));
    assert_eq!(header("content-type"), "application/zstd");
    let id = job.rsplit('/').next().unwrap();
    assert_eq!(header("content-disposition"), format!("attachment; filename=\"job-{id}.jsonl.zst\""));
    let bytes = response.bytes().await.unwrap().to_vec();
    // as it is: compressed once, though this client takes gzip
    assert_eq!(length, bytes.len().to_string());
    let digest: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(told, digest);
    (bytes, told)
}

/// Purges a job by its archive as it is now.
pub async fn purged(app: &TestApp, job: &str) -> Vec<u8> {
    let (bytes, told) = archived(app, job).await;
    let body = json!({"reason": "agreed", "archive_sha256": told});
    app.post(&format!("{job}/purge"), &body).await.expect(200);
    bytes
}

pub fn lines(archive: &[u8]) -> String {
    String::from_utf8(zstd::decode_all(archive).unwrap()).unwrap()
}

/// The program, told to do something, and what it printed.
fn flankfit(arguments: &[&str]) -> String {
    let run = Command::new(env!("CARGO_BIN_EXE_flankfit")).args(arguments).env_clear().output().unwrap();
    let printed = String::from_utf8([run.stdout, run.stderr].concat()).unwrap();
    assert!(run.status.success(), "{arguments:?}: {printed}");
    printed
}

/// What an archive becomes on its way through another database.
fn through_another(archive: &[u8], folder: &Path, name: &str) -> Vec<u8> {
    let [file, back] = ["there", "back"].map(|way| folder.join(format!("{name}-{way}.zst")));
    let url = format!("sqlite://{}", folder.join(format!("{name}.db")).display());
    fs::write(&file, archive).unwrap();
    let imported = flankfit(&["import", file.to_str().unwrap(), "--database-url", &url]);
    assert_eq!(imported, "1 jobs stored, 0 were there already\n");
    assert!(flankfit(&["audit", "verify", "--database-url", &url]).starts_with("intact: "));
    flankfit(&["export", back.to_str().unwrap(), "--database-url", &url]);
    fs::read(back).unwrap()
}

#[tokio::test]
async fn an_archive_is_the_same_file_while_nothing_changes() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    app.iteration(&job).await;
    let (first, told) = archived(&app, &job).await;
    assert_eq!(archived(&app, &job).await, (first.clone(), told.clone()));
    let text = lines(&first);
    assert!(text.contains("\"operator\":\"J. Doe\"") && text.contains("\n{\"whole\":{\"sections\":1,"), "{text}");
    // what it is when it is imported elsewhere, bit for bit
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(through_another(&first, folder.path(), "whole"), first);
    app.patch(&job, &json!({"name": "pinion"})).await.expect(200);
    assert_ne!(archived(&app, &job).await.1, told);
    app.post(&format!("{NOBODY}/archive"), &json!({})).await.problem(404, "not_found");
    app.stop().await;
}

/// Nodes that cannot be compressed: about 16 bytes of an archive for each.
pub fn noisy(count: u32) -> Value {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let x: Vec<f64> = (0..count).map(f64::from).collect();
    let y: Vec<f64> = x.iter().map(|_| next()).collect();
    json!({"nodes": {"type": "curve", "x": x, "y": y}, "model": {"type": "polynomial", "degree": 2}})
}

/// One whose archive does not fit into memory is sent from a file.
#[tokio::test]
async fn a_long_archive_is_whole() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let body = noisy(150_000);
    app.post(&format!("{job}/iterations"), &body).await.expect(201);
    let (bytes, told) = archived(&app, &job).await;
    assert!(bytes.len() > 1 << 20, "{}", bytes.len());
    assert!(lines(&bytes).ends_with("}}\n"));
    let purge = json!({"reason": "agreed", "archive_sha256": told});
    app.post(&format!("{job}/purge"), &purge).await.expect(200);
    app.stop().await;
}

#[tokio::test]
async fn a_purge_takes_the_digest_of_the_archive_as_it_is() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    app.iteration(&job).await;
    let place = format!("{job}/purge");
    let (_, told) = archived(&app, &job).await;
    let body = |digest: &str| json!({"reason": "agreed", "archive_sha256": digest});
    for wrong in ["", "0", &"0".repeat(63), &"g".repeat(64), &"0".repeat(64)] {
        assert_eq!(app.post(&place, &body(wrong)).await.problem(422, "invalid_request"), ["/archive_sha256"]);
    }
    assert_eq!(app.post(&place, &json!({"archive_sha256": told})).await.problem(422, "invalid_request"), ["/reason"]);
    let empty = json!({"reason": "", "archive_sha256": told});
    assert_eq!(app.post(&place, &empty).await.problem(422, "invalid_request"), ["/reason"]);
    // both at once
    let mut wrong =
        app.post(&place, &json!({"reason": "", "archive_sha256": "0"})).await.problem(422, "invalid_request");
    wrong.sort_unstable();
    assert_eq!(wrong, ["/archive_sha256", "/reason"]);
    app.post(&format!("{NOBODY}/purge"), &body(&told)).await.problem(404, "not_found");
    // one that has gone on since
    app.iteration(&job).await;
    let late = app.post(&place, &body(&told)).await;
    assert_eq!(late.problem(422, "invalid_request"), ["/archive_sha256"]);
    let detail = late.json()["detail"].as_str().unwrap().to_owned();
    assert!(
        detail.starts_with("/archive_sha256: the digest is not that of the job's archive as it stands now;"),
        "{detail}"
    );
    assert_eq!(app.get(&job).await.expect(200).json().get("purged_at"), None);

    // it is done once, whatever becomes of the answer
    let (_, told) = archived(&app, &job).await;
    let done = app.post_keyed(&place, "one", &body(&told.to_uppercase())).await.expect(200);
    let documented: PurgeBody = serde_json::from_str(&done.text).unwrap();
    assert_eq!(serde_json::to_value(documented).unwrap(), done.json());
    assert_eq!((&done.json()["reason"], &done.json()["archive_sha256"]), (&json!("agreed"), &json!(told)));
    let again = app.post_keyed(&place, "one", &body(&told.to_uppercase())).await.expect(200);
    assert_eq!((&again.text, again.header("idempotency-replayed")), (&done.text, Some("true")));
    let other = app.post_keyed(&place, "two", &body(&told)).await;
    other.problem(410, "purged");
    app.stop().await;
}

/// What there is of a job before it is purged.
struct Filled {
    job: String,
    fit: String,
    record: String,
    stream: String,
    finished: String,
}

async fn filled(app: &TestApp) -> Filled {
    let job = app.job().await;
    let place = format!("{job}/iterations");
    let first = app.post_keyed(&place, "iteration", &iteration()).await.expect(201).json();
    let refit = json!({"model": {"type": "polynomial", "degree": [1, 1]}, "reason": "J. Doe wanted it"});
    let refit = app.post(&format!("{place}/1/fits"), &refit).await.expect(201).json();
    let chosen = json!({"fit_id": refit["id"], "reason": "J. Doe likes it"});
    app.put(&format!("{place}/1/chosen_fit"), &chosen).await.expect(200);
    app.patch(&format!("{place}/1"), &json!({"decision": "remachine", "reason": "J. Doe says so"})).await.expect(200);
    let surface = json!({"method": {"type": "b_spline_least_squares", "degree": 2, "spans": [2, 2]}});
    let record = app.post(&format!("{place}/1/surfaces"), &surface).await;
    let spec = json!({"model": {"type": "polynomial", "degree": [1, 1]}});
    let [stream, finished] = [app.stream(&job, &spec).await, app.stream(&job, &spec).await];
    for stream in [&stream, &finished] {
        let block = json!({"sequence": 1, "nodes": nodes()});
        app.post(&format!("{stream}/nodes"), &block).await.expect(200);
    }
    app.post(&format!("{finished}/finish"), &json!({"operator": "J. Doe"})).await.expect(201);
    let record = record.expect(201).header("location").unwrap().to_owned();
    Filled { job, fit: first["fits"][0]["id"].as_str().unwrap().to_owned(), record, stream, finished }
}

/// The time in a detail is written as times are elsewhere.
#[track_caller]
pub fn is_gone(answer: &Answer, what: &str) {
    answer.problem(410, "purged");
    let detail = answer.json()["detail"].as_str().unwrap().to_owned();
    assert!(detail.starts_with("The job was purged at 20") && detail.contains("(agreed)"), "{what}: {detail}");
    let time = detail.split(' ').nth(5).unwrap();
    assert!(time.len() == 27 && time.ends_with('Z') && &time[19..20] == ".", "{detail}");
}

#[tokio::test]
async fn what_was_purged_is_gone_and_its_numbers_stay() {
    let mut app = TestApp::start().await;
    let Filled { job, fit, record, stream, finished } = filled(&app).await;
    let place = format!("{job}/iterations/1");
    let figures = app.get(&place).await.expect(200);
    let tag = figures.header("etag").unwrap().to_owned();
    let whole = purged(&app, &job).await;

    // what needs it
    let model = json!({"model": {"type": "polynomial", "degree": [1, 1]}});
    let block = json!({"sequence": 2, "nodes": nodes()});
    let reads = [
        format!("{place}/nodes"),
        format!("{place}/fits/{fit}"),
        format!("{place}/fits/{fit}?include=residuals"),
        record,
        stream.clone(),
        finished.clone(),
    ];
    for read in &reads {
        is_gone(&app.get(read).await, read);
    }
    let surface = json!({"method": {"type": "b_spline_least_squares", "degree": 2, "spans": [2, 2]}});
    let with_prior = {
        let mut body = iteration();
        body["prior"] = json!({"iterations": "previous"});
        body
    };
    let posts = [
        (format!("{place}/fits/{fit}/replay"), json!({})),
        (format!("{place}/fits"), model.clone()),
        (format!("{place}/preview"), model.clone()),
        (format!("{place}/surfaces"), surface),
        (format!("{job}/iterations"), iteration()),
        (format!("{job}/iterations"), with_prior),
        (format!("{job}/streams"), model),
        (format!("{stream}/nodes"), block.clone()),
        // also what was answered before
        (format!("{stream}/nodes"), json!({"sequence": 1, "nodes": nodes()})),
        (format!("{stream}/finish"), json!({})),
        (format!("{finished}/finish"), json!({})),
    ];
    for (path, body) in &posts {
        is_gone(&app.post(path, body).await, path);
    }
    // the answer that was kept told of it
    is_gone(&app.post_keyed(&format!("{job}/iterations"), "iteration", &iteration()).await, "a kept answer");
    is_gone(&app.put(&format!("{place}/chosen_fit"), &json!({"fit_id": fit})).await, "a choice");
    is_gone(&app.patch(&place, &json!({"decision": "accept"})).await, "a decision");
    is_gone(&app.patch(&job, &json!({"name": "x"})).await, "a change");
    is_gone(&app.delete(&job).await, "an end");
    is_gone(&app.delete(&stream).await, "a stream's end");

    // what stays
    let told = app.get(&job).await.expect(200);
    assert!(told.json()["purged_at"].is_string(), "{}", told.text);
    assert_eq!(app.get("/v1/jobs").await.expect(200).json()["items"][0]["purged_at"], told.json()["purged_at"]);
    let is = app.get(&place).await.expect(200);
    assert_ne!(is.header("etag"), Some(tag.as_str()), "another tag, since it is another answer");
    let (is, mut was) = (is.json(), figures.json());
    assert_eq!(is["purged_at"], told.json()["purged_at"]);
    for gone in ["operator", "note"] {
        assert_eq!((is.get(gone), was[gone].is_string()), (None, true), "{gone}");
        was.as_object_mut().unwrap().remove(gone);
    }
    was["purged_at"] = is["purged_at"].clone();
    was["fits"][1].as_object_mut().unwrap().remove("reason");
    assert_eq!(is, was);
    let trace = app.get(&format!("{job}/trace")).await.expect(200);
    assert!(!trace.text.contains("J. Doe"), "{}", trace.text);
    let trace = trace.json();
    assert_eq!(trace["job"], told.json());
    let traced = &trace["iterations"][0];
    assert_eq!((&traced["decision"], &traced["fits"][0]["coefficients"]), (&json!("remachine"), &json!([])));
    assert_eq!(traced["fits"][0]["rms"], is["fits"][0]["rms"]);
    assert_eq!(app.get(&format!("{place}/fits")).await.expect(200).json()["items"].as_array().unwrap().len(), 2);
    assert_eq!(app.get(&format!("{place}/records")).await.expect(200).json()["items"].as_array().unwrap().len(), 1);
    let verdict = app.get(&format!("{job}/audit/verify")).await.expect(200).json();
    assert_eq!(verdict["intact"], true, "{verdict}");
    // and can be taken elsewhere, as what was taken away can
    let (left, _) = archived(&app, &job).await;
    assert!(!lines(&left).contains("J. Doe") && lines(&left).contains("\n{\"purge\":{"), "{}", lines(&left));
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(through_another(&left, folder.path(), "left"), left);
    assert_eq!(through_another(&whole, folder.path(), "whole"), whole);
    app.stop().await;
}

/// What is under way keeps a purge from it; what comes afterwards is refused.
#[tokio::test]
async fn an_operation_that_has_not_ended_keeps_a_purge() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let request = app.request(Method::POST, &format!("{job}/iterations")).header("prefer", "respond-async");
    let begun = send(request.json(&trimmed(100))).await.expect(202);
    let operation = begun.header("location").unwrap().to_owned();
    let (_, told) = archived(&app, &job).await;
    let body = json!({"reason": "agreed", "archive_sha256": told});
    let busy = app.post(&format!("{job}/purge"), &body).await;
    busy.problem(409, "conflict");
    assert!(busy.text.contains("1 operation that has not ended"), "{}", busy.text);
    app.delete(&operation).await.expect(204);
    app.get(&operation).await.expect(200);
    purged(&app, &job).await;
    // it would tell what was asked for
    app.get(&operation).await.problem(404, "not_found");
    app.stop().await;
}

/// Pages in use, and the free ones.
async fn pages(file: &Path) -> (i64, i64) {
    let options = sqlx::sqlite::SqliteConnectOptions::new().filename(file).read_only(true);
    let mut own = sqlx::ConnectOptions::connect(&options).await.unwrap();
    let all: i64 = sqlx::query_scalar("PRAGMA page_count").fetch_one(&mut own).await.unwrap();
    let free: i64 = sqlx::query_scalar("PRAGMA freelist_count").fetch_one(&mut own).await.unwrap();
    sqlx::Connection::close(own).await.unwrap();
    (all - free, free)
}

/// The file of an SQLite database, and the log beside it, have neither the names nor the space.
#[tokio::test]
async fn nobodys_name_is_left_in_the_file() {
    let mut app = TestApp::start_on_file().await;
    let named = |k: usize| {
        let mut body = iteration();
        body["operator"] = json!(format!("Canary Bird the {k}th"));
        // longer than a page of the file
        body["note"] = json!("Canary€€€€".repeat(400));
        body
    };
    // beside others, so that pages are shared, split and filled anew
    let (job, other) = (app.job().await, app.job().await);
    for k in 0..60 {
        app.post_keyed(&format!("{job}/iterations"), &format!("k{k}"), &named(k)).await.expect(201);
        app.iteration(&other).await;
    }
    let holds = |file: &Path| {
        let log = file.with_file_name("test.db-wal");
        [file, &log].into_iter().any(|file| {
            let bytes = fs::read(file).unwrap_or_default();
            bytes.windows(6).any(|piece| piece == b"Canary")
        })
    };
    let file = app.database();
    assert!(holds(&file));
    let (before, _) = pages(&file).await;
    purged(&app, &job).await;
    assert!(!holds(&file));
    let (after, free) = pages(&file).await;
    assert!(after < before * 3 / 4 && free > before / 5, "{before} pages in use, then {after}, {free} free");
    // what was freed is used again
    for _ in 0..20 {
        app.iteration(&other).await;
    }
    assert!(pages(&file).await.1 < free);
    app.stop().await;
}

/// Where something was changed behind the service's back, nothing is taken away.
#[tokio::test]
async fn a_broken_audit_keeps_what_there_is_to_find_out_by() {
    let mut app = TestApp::start_on_file().await;
    let job = app.job().await;
    app.iteration(&job).await;
    app.restart_after(async |database| {
        let options = sqlx::sqlite::SqliteConnectOptions::new().filename(database);
        let mut own = sqlx::ConnectOptions::connect(&options).await.unwrap();
        let sql = "DROP TRIGGER iterations_no_update; UPDATE iterations SET instrument = 'other'";
        sqlx::raw_sql(sql).execute(&mut own).await.unwrap();
        sqlx::Connection::close(own).await.unwrap();
    })
    .await;
    let (_, told) = archived(&app, &job).await;
    let refused = app.post(&format!("{job}/purge"), &json!({"reason": "agreed", "archive_sha256": told})).await;
    refused.problem(409, "conflict");
    assert!(refused.text.contains("broken at entry 2"), "{}", refused.text);
    assert_eq!(app.get(&format!("{job}/iterations/1")).await.expect(200).json()["operator"], Value::from("J. Doe"));
    app.stop().await;
}
