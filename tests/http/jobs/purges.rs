//! Jobs that are archived and purged: what is left, what is 410, and that nothing of people stays.

use std::{fs, path::Path, process::Command};

use flankfit::{api::jobs::purge::PurgeBody, jobs::Caller};
use serde_json::json;

use super::app::{Answer, TestApp, iteration, nodes};

const NOBODY: &str = "/v1/jobs/0190b0de-0000-7000-8000-000000000000";

/// The archive of a job.
pub async fn archived(app: &TestApp, job: &str) -> String {
    let answer = app.get(&format!("{job}/archive")).await.expect(200);
    assert_eq!(answer.header("content-type"), Some("application/jsonl"));
    let id = job.rsplit('/').next().unwrap();
    let name = format!("attachment; filename=\"job-{id}.jsonl\"");
    assert_eq!(answer.header("content-disposition"), Some(name.as_str()));
    assert!(answer.text.ends_with("\n{\"archive\":{\"jobs\":1}}\n"), "{}", answer.text);
    answer.text
}

pub async fn purged(app: &TestApp, job: &str) {
    app.post(&format!("{job}/purge"), &json!({"reason": "agreed"})).await.expect(200);
}

/// Runs the program with these arguments and returns its output.
fn flankfit(arguments: &[&str]) -> String {
    let run = Command::new(env!("CARGO_BIN_EXE_flankfit")).args(arguments).env_clear().output().unwrap();
    let printed = String::from_utf8([run.stdout, run.stderr].concat()).unwrap();
    assert!(run.status.success(), "{arguments:?}: {printed}");
    printed
}

/// Archive after an import into another database and an export from there.
fn through_another(archive: &str, folder: &Path, name: &str) -> String {
    let file = folder.join(name);
    let url = format!("sqlite://{}", folder.join(format!("{name}.db")).display());
    fs::write(&file, archive).unwrap();
    let imported = flankfit(&["import", file.to_str().unwrap(), "--database-url", &url]);
    assert_eq!(imported, "1 jobs stored, 0 existed already\n");
    assert!(flankfit(&["audit", "verify", "--database-url", &url]).starts_with("intact: "));
    flankfit(&["export", "--database-url", &url])
}

/// Archives of a real server are read back.
#[tokio::test]
async fn an_archive_is_the_same_while_nothing_changes_and_elsewhere() {
    let mut app = TestApp::start().await;
    let Filled { job, .. } = filled(&app).await;
    let first = archived(&app, &job).await;
    assert_eq!(archived(&app, &job).await, first);
    assert!(first.contains("\"operator\":\"J. Doe\""), "{first}");
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(through_another(&first, folder.path(), "whole"), first);
    app.patch(&job, &json!({"name": "pinion"})).await.expect(200);
    assert_ne!(archived(&app, &job).await, first);
    app.get(&format!("{NOBODY}/archive")).await.problem(404, "not_found");
    app.stop().await;
}

/// Before the answer begins.
#[tokio::test]
async fn an_archive_that_finds_no_connection_is_refused() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let jobs = app.state().jobs.of(&Caller::anonymous());
    let places: Vec<_> = std::iter::from_fn(|| jobs.archiving()).collect();
    assert_eq!(places.len(), 2);
    let answer = app.get(&format!("{job}/archive")).await;
    answer.problem(503, "overloaded");
    assert_eq!(answer.header("retry-after"), Some("5"));
    drop(places);
    archived(&app, &job).await;
    app.stop().await;
}

#[tokio::test]
async fn a_purge_is_done_once() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    app.iteration(&job).await;
    let (place, body) = (format!("{job}/purge"), json!({"reason": "agreed"}));
    assert_eq!(app.post(&place, &json!({"reason": ""})).await.problem(422, "invalid_request"), ["/reason"]);
    let mut both = app.post(&place, &json!({"why": "x"})).await.problem(422, "invalid_request");
    both.sort_unstable();
    assert_eq!(both, ["/reason", "/why"]);
    app.post(&format!("{NOBODY}/purge"), &body).await.problem(404, "not_found");
    assert_eq!(app.get(&job).await.expect(200).json().get("purged_at"), None);
    let done = app.post_keyed(&place, "one", &body).await.expect(200);
    let documented: PurgeBody = serde_json::from_str(&done.text).unwrap();
    assert_eq!(serde_json::to_value(documented).unwrap(), done.json());
    assert_eq!(done.json()["reason"], "agreed");
    let again = app.post_keyed(&place, "one", &body).await.expect(200);
    assert_eq!((&again.text, again.header("idempotency-replayed")), (&done.text, Some("true")));
    app.post_keyed(&place, "two", &body).await.problem(410, "purged");
    app.stop().await;
}

/// Content of a job before it is purged.
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
    app.put(&format!("{place}/1/chosen-fit"), &chosen).await.expect(200);
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
async fn purged_data_is_gone_and_its_numbers_stay() {
    let mut app = TestApp::start().await;
    let Filled { job, fit, record, stream, finished } = filled(&app).await;
    let place = format!("{job}/iterations/1");
    let figures = app.get(&place).await.expect(200);
    let tag = figures.header("etag").unwrap().to_owned();
    let whole = archived(&app, &job).await;
    purged(&app, &job).await;

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
        format!("{job}/streams"),
        format!("{job}/correction"),
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
        (format!("{job}/correction"), json!({"sensitivity": {"type": "machine", "machine": "form_grinding"}})),
        (format!("{job}/correction/applied"), json!({"settings": {}})),
        (format!("{stream}/nodes"), block.clone()),
        // also blocks that were acknowledged before
        (format!("{stream}/nodes"), json!({"sequence": 1, "nodes": nodes()})),
        (format!("{stream}/finish"), json!({})),
        (format!("{finished}/finish"), json!({})),
    ];
    for (path, body) in &posts {
        is_gone(&app.post(path, body).await, path);
    }
    // the kept response referred to it
    is_gone(&app.post_keyed(&format!("{job}/iterations"), "iteration", &iteration()).await, "a kept answer");
    is_gone(&app.put(&format!("{place}/chosen-fit"), &json!({"fit_id": fit})).await, "a choice");
    is_gone(&app.patch(&place, &json!({"decision": "accepted"})).await, "a decision");
    is_gone(&app.patch(&job, &json!({"name": "x"})).await, "a change");
    is_gone(&app.delete(&job).await, "an end");
    is_gone(&app.delete(&stream).await, "a stream's end");

    // what stays
    let stored = app.get(&job).await.expect(200);
    assert!(stored.json()["purged_at"].is_string(), "{}", stored.text);
    assert_eq!(app.get("/v1/jobs").await.expect(200).json()["items"][0]["purged_at"], stored.json()["purged_at"]);
    let is = app.get(&place).await.expect(200);
    assert_ne!(is.header("etag"), Some(tag.as_str()), "another tag, since it is another answer");
    let (is, mut was) = (is.json(), figures.json());
    assert_eq!(is["purged_at"], stored.json()["purged_at"]);
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
    assert_eq!(trace["job"], stored.json());
    let traced = &trace["iterations"][0];
    assert_eq!((&traced["decision"], &traced["fits"][0]["coefficients"]), (&json!("remachine"), &json!([])));
    assert_eq!(traced["fits"][0]["rms"], is["fits"][0]["rms"]);
    assert_eq!(app.get(&format!("{place}/fits")).await.expect(200).json()["items"].as_array().unwrap().len(), 2);
    assert_eq!(app.get(&format!("{place}/records")).await.expect(200).json()["items"].as_array().unwrap().len(), 1);
    let verdict = app.get(&super::audit::verify_of(&job)).await.expect(200).json();
    assert_eq!(verdict["intact"], true, "{verdict}");
    // and can be taken elsewhere, as what was taken away can
    let left = archived(&app, &job).await;
    assert!(!left.contains("J. Doe") && left.contains("\n{\"purges\":{"), "{left}");
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(through_another(&left, folder.path(), "left"), left);
    assert_eq!(through_another(&whole, folder.path(), "whole"), whole);
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

/// The file of an SQLite database and its log have neither the names nor the space.
#[tokio::test]
async fn no_name_is_left_in_the_file() {
    let mut app = TestApp::start_on_file().await;
    let named = |k: usize| {
        let mut body = iteration();
        body["operator"] = json!(format!("Canary Bird the {k}th"));
        // longer than a page of the file
        body["note"] = json!("Canary€€€€".repeat(400));
        body
    };
    // next to others, so that pages are shared, split and filled anew
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
