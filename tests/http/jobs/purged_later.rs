//! Purges and archives that take long, two at once, and what is asked of a purged job for later.

use std::{fs, process::Command};

use reqwest::Method;
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};

use super::{
    app::{TestApp, iteration, send},
    events::Listener,
    long::robust_iteration,
    purges::{NOBODY, archived, is_gone, lines, noisy, purged},
};
use crate::harness;

/// What would be done later of a purged job is refused at once, as the plain request is.
#[tokio::test]
async fn what_is_asked_of_a_purged_job_for_later_is_refused_at_once() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    app.iteration(&job).await;
    purged(&app, &job).await;
    let model = json!({"model": {"type": "polynomial", "degree": [1, 1]}});
    let surface = json!({"method": {"type": "b_spline_least_squares", "degree": 2, "spans": [2, 2]}});
    let purge = json!({"reason": "again", "archive_sha256": "0".repeat(64)});
    let posts = [
        (format!("{job}/iterations"), iteration()),
        (format!("{job}/iterations"), robust_iteration()),
        (format!("{job}/iterations/1/fits"), model),
        (format!("{job}/iterations/1/surfaces"), surface),
        (format!("{job}/purge"), purge),
    ];
    for (path, body) in &posts {
        let later = app.request(Method::POST, path).header("prefer", "respond-async").json(body);
        is_gone(&send(later).await, path);
        let later = app.request(Method::POST, path).header("prefer", "respond-async, wait=5").json(body);
        is_gone(&send(later.header("idempotency-key", "k")).await, path);
    }
    assert_eq!(app.get("/v1/operations").await.expect(200).json()["items"], json!([]));
    app.stop().await;
}

/// One that takes long can be done later. It is no event of its job before it is done, since the
/// archive that it names has all of them.
#[tokio::test]
async fn a_purge_can_be_done_later() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    app.iteration(&job).await;
    let mut heard = Listener::of(app.request(Method::GET, &format!("{job}/events")), Some("latest")).await.unwrap();
    let place = format!("{job}/purge");
    let later = |body: &Value| app.request(Method::POST, &place).header("prefer", "respond-async").json(body);
    // faults that are known are told at once
    let wrong = later(&json!({"reason": "", "archive_sha256": "0"}));
    send(wrong).await.problem(422, "invalid_request");
    let nobody = app.request(Method::POST, &format!("{NOBODY}/purge")).header("prefer", "respond-async");
    let body = json!({"reason": "agreed", "archive_sha256": "0".repeat(64)});
    send(nobody.json(&body)).await.problem(404, "not_found");
    // that the archive is another one takes an archive to be found
    let other = send(later(&body)).await.expect(202).header("location").unwrap().to_owned();
    let result = async |operation: &str| {
        send(app.request(Method::GET, &format!("{operation}/result")).header("prefer", "wait=60")).await
    };
    assert_eq!(result(&other).await.problem(422, "invalid_request"), ["/archive_sha256"]);
    let (_, told) = archived(&app, &job).await;
    let body = json!({"reason": "agreed", "archive_sha256": told});
    let keyed = |key: &str| later(&body).header("idempotency-key", key);
    let operation = send(keyed("one")).await.expect(202).header("location").unwrap().to_owned();
    let done = result(&operation).await.expect(200);
    assert_eq!((&done.json()["reason"], &done.json()["archive_sha256"]), (&json!("agreed"), &json!(told)));
    assert_eq!(app.get(&operation).await.expect(200).json()["state"], "succeeded");
    let (_, name, data) = heard.next().await.unwrap();
    assert_eq!((name.as_str(), &data["reason"]), ("purged", &json!("agreed")), "{data}");
    assert_eq!(data["created_at"], app.get(&job).await.expect(200).json()["purged_at"]);
    // it was done once, and is told again by its key
    let again = app.post_keyed(&place, "one", &body).await.expect(200);
    assert_eq!((&again.text, again.header("idempotency-replayed")), (&done.text, Some("true")));
    is_gone(&send(keyed("two")).await, "another purge");
    assert_eq!(app.get(&format!("{job}/audit/verify")).await.expect(200).json()["intact"], true);
    app.stop().await;
}

/// Of two at once one is done, and the other is told so: never that its digest is wrong.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn of_two_purges_one_is_gone() {
    let mut app = TestApp::start().await;
    for _ in 0..6 {
        let job = app.job().await;
        app.iteration(&job).await;
        let (_, told) = archived(&app, &job).await;
        let (place, body) = (format!("{job}/purge"), json!({"reason": "agreed", "archive_sha256": told}));
        let asked = [(); 3].map(|()| app.post(&place, &body));
        let answers = futures_util::future::join_all(asked).await;
        assert_eq!(answers.iter().filter(|answer| answer.status == 200).count(), 1);
        for refused in answers.iter().filter(|answer| answer.status != 200) {
            is_gone(refused, "the other");
        }
    }
    app.stop().await;
}

/// An archive that takes longer than a request may is sent while it is written, and is whole; what
/// needs it once more is done later.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_archive_outlives_the_time_of_a_request() {
    let mut app = TestApp::start_on_file().await;
    let job = app.job().await;
    let body = noisy(100_000);
    for _ in 0..10 {
        app.post(&format!("{job}/iterations"), &body).await.expect(201);
    }
    let directory = app.stop_server().await;
    let url = crate::database::in_file(&directory.path().join("test.db"));
    let short = |settings: &mut flankfit::config::ServeSettings| {
        settings.request_timeout = 2;
        settings.database_url = url;
    };
    let mut app = TestApp::around(harness::TestApp::start_in(directory, short).await);
    let begun = std::time::Instant::now();
    let response = app.request(Method::POST, &format!("{job}/archive")).send().await.unwrap();
    assert_eq!(response.status(), 200);
    let (head, told) = (begun.elapsed(), response.headers().get("archive-sha256").cloned());
    assert!(head < std::time::Duration::from_secs(10), "{head:?}");
    let bytes = response.bytes().await.unwrap().to_vec();
    println!(
        "{} bytes in {:?}, begun after {head:?}, digest in the head: {}",
        bytes.len(),
        begun.elapsed(),
        told.is_some()
    );
    let digest: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    assert!(told.is_none_or(|told| told.to_str().unwrap() == digest));
    let text = lines(&bytes);
    assert!(bytes.len() > 5 << 20 && text.lines().last().unwrap().starts_with("{\"whole\":{\"sections\":1,"));
    // the digest of what came is that of the archive
    let purge = json!({"reason": "agreed", "archive_sha256": digest});
    let later = app.request(Method::POST, &format!("{job}/purge")).header("prefer", "respond-async").json(&purge);
    let operation = send(later).await.expect(202).header("location").unwrap().to_owned();
    let begun = std::time::Instant::now();
    while app.get(&operation).await.expect(200).json()["ended_at"].is_null() {
        assert!(begun.elapsed() < std::time::Duration::from_secs(120));
        tokio::time::sleep(std::time::Duration::from_millis(100)).await;
    }
    assert_eq!(app.get(&format!("{operation}/result")).await.expect(200).json()["archive_sha256"], json!(digest));
    assert!(app.get(&job).await.expect(200).json()["purged_at"].is_string());
    app.stop().await;
}

/// A few bytes of a file that say they are a gigabyte end in an error that says where.
#[tokio::test]
async fn a_hostile_archive_is_refused_by_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let (file, url) = (folder.path().join("hostile.zst"), format!("sqlite://{}", folder.path().join("a.db").display()));
    let mut packed = zstd::stream::write::Encoder::new(Vec::new(), 1).unwrap();
    let section = r#"{"section":{"tenant":"default","job":"0190b0de-0000-7000-8000-000000000000"}}"#;
    std::io::Write::write_all(
        &mut packed,
        format!("{{\"flankfit\":\"export\",\"version\":1}}\n{section}\n").as_bytes(),
    )
    .unwrap();
    let blank = vec![b' '; 1 << 20];
    for _ in 0..1200 {
        std::io::Write::write_all(&mut packed, &blank).unwrap();
    }
    let packed = packed.finish().unwrap();
    assert!(packed.len() < 300_000, "{}", packed.len());
    fs::write(&file, packed).unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_flankfit"))
        .args(["import", file.to_str().unwrap(), "--database-url", &url])
        .env_clear()
        .output()
        .unwrap();
    let said = String::from_utf8(run.stderr).unwrap();
    assert!(!run.status.success() && said.contains("line 3 of the file is longer than 1073741824 bytes"), "{said}");
}
