//! Audit as it is returned, and as another program verifies it.

use std::{path::Path, process::Command};

use flankfit::api::{
    jobs::audit::{EntryBody, VerdictBody},
    page::PageBody,
};
use reqwest::Method;
use serde_json::{Value, json};

use super::{
    app::{TestApp, nodes, send},
    purges::{archived, purged},
};

/// The path at which the audit of a job is verified.
pub fn verify_of(job: &str) -> String {
    format!("/v1/audit/verify?job={}", job.rsplit('/').next().unwrap())
}

/// Address of the job's audit.
fn audit_of(job: &str) -> String {
    format!("/v1/audit?job={}", job.rsplit('/').next().unwrap())
}

#[tokio::test]
async fn the_audit_of_a_job_names_actor_and_change() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    app.iteration(&job).await;
    let patch = app.request(Method::PATCH, &job).header("x-request-id", "line-4/shift-2");
    send(patch.json(&json!({"name": "pinion"}))).await.expect(200);
    let page: PageBody<EntryBody> = serde_json::from_str(&app.get(&audit_of(&job)).await.expect(200).text).unwrap();
    assert_eq!(page.next_cursor, None);
    let actions: Vec<_> = page.items.iter().map(|e| (&*e.action, &*e.subject)).collect();
    let first = format!("{job}/iterations/1");
    assert_eq!(actions, [("job.create", &*job), ("iteration.add", &*first), ("job.change", &*job)]);
    assert!(
        page.items.iter().all(|e| e.actor.as_deref() == Some("anonymous") && e.peer.as_deref() == Some("127.0.0.1"))
    );
    assert_eq!(page.items[2].request_id.as_deref(), Some("line-4/shift-2"));
    assert!(page.items[1].contents.keys().eq(["fit_choices/1/1", "fits/1/1", "iterations/1", "nodes/1"]));
    assert!(page.items[1].contents.values().all(|digest| digest.len() == 64));
    // what is refused, and what changes nothing, is not entered
    app.delete(&job).await.problem(409, "conflict");
    app.patch(&job, &json!({"name": "pinion"})).await.expect(200);
    for path in [verify_of(&job), "/v1/audit/verify".to_owned()] {
        let verdict: VerdictBody = serde_json::from_str(&app.get(&path).await.expect(200).text).unwrap();
        // the first seal is made ten seconds after the start
        assert_eq!(verdict, VerdictBody { intact: true, entries: 3, unsealed: 3, differences: Vec::new() });
    }
    // page by page
    let one = app.get(&format!("{}&limit=2", audit_of(&job))).await.expect(200).json();
    let next = one["next_cursor"].as_str().unwrap();
    let two = app.get(&format!("{}&limit=2&cursor={next}", audit_of(&job))).await.expect(200).json();
    assert_eq!((&two["items"][0]["action"], two.get("next_cursor")), (&json!("job.change"), None));
    assert_eq!(app.get("/v1/audit").await.expect(200).json()["items"].as_array().unwrap().len(), 3);
    let nobody = "/v1/jobs/0190b0de-0000-7000-8000-000000000000";
    app.get(&audit_of(nobody)).await.problem(404, "not_found");
    app.get(&verify_of(nobody)).await.problem(404, "not_found");
    assert_eq!(app.get("/v1/audit?limit=0").await.problem(422, "invalid_request"), ["/limit"]);
    assert_eq!(app.get("/v1/audit/verify?job=x").await.problem(422, "invalid_request"), ["/job"]);
    app.stop().await;
}

#[tokio::test]
async fn a_deleted_job_leaves_its_entries() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    app.delete(&job).await.expect(204);
    let audit = app.get(&audit_of(&job)).await.expect(200).json();
    assert_eq!(audit["items"][1]["action"], "job.delete");
    assert_eq!(app.get(&verify_of(&job)).await.expect(200).json()["entries"], 2);
    app.stop().await;
}

#[test]
fn the_verifier_prints_its_usage_and_unreadable_input() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/verify_audit.py");
    let run = |arguments: &[&str]| {
        let output = Command::new("python3").arg(&script).args(arguments).output().unwrap();
        let said = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        assert!(!said.contains("Traceback"), "{said}");
        (output.status.code(), said)
    };
    let (code, said) = run(&["--help"]);
    assert!(code == Some(0) && said.contains("--against SEALS") && said.contains("--archive ARCHIVE"), "{said}");
    let (code, said) = run(&["default", "/no/such/file"]);
    assert!(code == Some(2) && said.starts_with("not found out: "), "{said}");
    assert_eq!(run(&[]).0, Some(2));
    assert_eq!(run(&["default"]), (Some(0), "intact 0 -\n".to_owned()));
}

/// `tools/verify_audit.py` finds the rows of an archive in the returned entries.
#[tokio::test]
async fn python_knows_the_rows_of_an_archive() {
    let mut app = TestApp::start().await;
    let (job, other) = (app.job().await, app.job().await);
    app.iteration(&job).await;
    app.iteration(&other).await;
    app.patch(&job, &json!({"name": "pinion"})).await.expect(200);
    let spec = json!({"model": {"type": "polynomial", "degree": [1, 1]}});
    let [gone, finished, stream] =
        [app.stream(&job, &spec).await, app.stream(&job, &spec).await, app.stream(&job, &spec).await];
    for stream in [&gone, &finished, &stream] {
        // of more than 64 nodes the estimate is stored
        for sequence in 1..=2 {
            app.post(&format!("{stream}/nodes"), &json!({"sequence": sequence, "nodes": nodes()})).await.expect(200);
        }
    }
    app.delete(&gone).await.expect(204);
    app.post(&format!("{finished}/finish"), &json!({})).await.expect(201);
    let stream_id = stream.rsplit('/').next().unwrap();
    let archive = archived(&app, &job).await;
    let page = app.get("/v1/audit").await.expect(200).json();
    let folder = tempfile::tempdir().unwrap();
    let with_page = |archive: &str, page: &Value| {
        let file = folder.path().join("archive");
        std::fs::write(&file, archive).unwrap();
        by_python_with(&["--archive", file.to_str().unwrap()], page)
    };
    let by_python = |archive: &str| with_page(archive, &page);
    assert_eq!(by_python(&archive), "intact 0 -");
    assert_eq!(by_python(&archive.replace("J. Doe", "J. Roe")), "iterations/1 row");
    let without = |table: &str| {
        let lines = archive.split_inclusive('\n').filter(|line| !line.starts_with(&format!("{{\"{table}\":")));
        by_python(&lines.collect::<String>())
    };
    assert_eq!(["nodes", "fits", "jobs"].map(without), ["nodes/1 row", "fits/1/1 row", "jobs/1 row"]);
    let [block, state] =
        [("blocks", 1), ("states", 2)].map(|(of, number)| format!("stream_{of}/{stream_id}/{number} row"));
    assert_eq!(["stream_blocks", "stream_states"].map(without), [block, state]);
    // a later entry does not outvote an earlier one
    let mut forged = page.clone();
    let entries = forged["items"].as_array_mut().unwrap();
    let genuine = entries.iter().find(|entry| entry["contents"].get("nodes/1").is_some()).unwrap().clone();
    entries.push(genuine);
    let first = entries.iter_mut().find(|entry| entry["contents"].get("nodes/1").is_some()).unwrap();
    first["contents"]["nodes/1"] = json!("00".repeat(32));
    assert_eq!(with_page(&archive, &forged), "nodes/1 row");
    purged(&app, &job).await;
    app.stop().await;
}

/// Output of the program, also if it refuses the seals.
pub fn by_python_with(options: &[&str], page: &Value) -> String {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("page.json");
    std::fs::write(&file, page.to_string()).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/verify_audit.py");
    let output = Command::new("python3").arg(script).args(options).arg("default").arg(file).output();
    let output = output.expect("python3 is there");
    String::from_utf8([output.stdout, output.stderr].concat()).unwrap().trim().to_owned()
}
