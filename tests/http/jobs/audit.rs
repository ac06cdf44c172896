//! Who changed what, as it is answered, and as somebody else's program verifies it.

use std::{path::Path, process::Command};

use flankfit::api::jobs::audit::{AuditPageBody, VerdictBody};
use reqwest::Method;
use serde_json::{Value, json};

use super::app::{TestApp, send};

#[tokio::test]
async fn a_job_tells_who_changed_what() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    app.iteration(&job).await;
    let patch = app.request(Method::PATCH, &job).header("x-request-id", "line-4/shift-2");
    send(patch.json(&json!({"name": "pinion"}))).await.expect(200);
    let page: AuditPageBody = serde_json::from_str(&app.get(&format!("{job}/audit")).await.expect(200).text).unwrap();
    assert_eq!(page.next_cursor, None);
    let told: Vec<_> = page.items.iter().map(|e| (e.number, &*e.action, &*e.target, &*e.outcome)).collect();
    let first = format!("{job}/iterations/1");
    assert_eq!(
        told,
        [
            (1, "job.create", &*job, "stored"),
            (2, "iteration.add", &*first, "stored"),
            (3, "job.change", &*job, "changed")
        ]
    );
    assert!(page.items.windows(2).all(|pair| pair[1].previous == pair[0].sha256));
    assert!(
        page.items.iter().all(|e| e.actor.as_deref() == Some("anonymous") && e.peer.as_deref() == Some("127.0.0.1"))
    );
    assert_eq!(page.items[2].request_id.as_deref(), Some("line-4/shift-2"));
    assert!(page.items[1].contents.keys().eq(["_salt", "choice", "fit", "iteration", "nodes"]));
    assert!(page.items[1].contents.values().all(|digest| digest.len() == 64));
    // what is refused, and what changes nothing, is not entered
    app.delete(&job).await.problem(409, "conflict");
    app.patch(&job, &json!({"name": "pinion"})).await.expect(200);
    let verdict: VerdictBody =
        serde_json::from_str(&app.get(&format!("{job}/audit/verify")).await.expect(200).text).unwrap();
    let head = Some(page.items[2].sha256.clone());
    assert_eq!(verdict, VerdictBody { intact: true, entries: Some(3), head, number: None, what: None });
    // page by page
    let one = app.get(&format!("{job}/audit?limit=2")).await.expect(200).json();
    let next = one["next_cursor"].as_str().unwrap();
    let two = app.get(&format!("{job}/audit?limit=2&cursor={next}")).await.expect(200).json();
    assert_eq!((two["items"][0]["number"].as_u64(), two.get("next_cursor")), (Some(3), None));
    assert_eq!(app.get("/v1/audit").await.expect(200).json(), json!({"items": []}));
    let nobody = "/v1/jobs/0190b0de-0000-7000-8000-000000000000/audit";
    app.get(nobody).await.problem(404, "not_found");
    app.get(&format!("{nobody}/verify")).await.problem(404, "not_found");
    assert_eq!(app.get(&format!("{job}/audit?limit=0")).await.problem(422, "invalid_request"), ["/limit"]);
    app.stop().await;
}

#[tokio::test]
async fn a_deleted_job_leaves_its_entries() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    app.delete(&job).await.expect(204);
    let told = app.get(&format!("{job}/audit")).await.expect(200).json();
    assert_eq!(told["items"][1]["action"], "job.delete");
    assert_eq!(app.get(&format!("{job}/audit/verify")).await.expect(200).json()["entries"], 2);
    app.stop().await;
}

/// `tools/verify_audit.py`, which has nothing but the answers, comes to the same.
#[tokio::test]
async fn python_agrees() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    app.iteration(&job).await;
    send(app.request(Method::PATCH, &job).header("x-request-id", "a/b").json(&json!({"name": "é"}))).await.expect(200);
    let page = app.get(&format!("{job}/audit")).await.expect(200).json();
    let id = job.rsplit('/').next().unwrap();
    let head = page["items"][2]["sha256"].as_str().unwrap();
    assert_eq!(by_python(id, &page), format!("intact 3 {head}"));
    let tampered = |change: fn(&mut Value)| {
        let mut page = page.clone();
        change(&mut page["items"]);
        by_python(id, &page)
    };
    assert_eq!(tampered(|items| items[1]["actor"] = json!("other")), "2 entry");
    assert_eq!(tampered(|items| items[2]["contents"]["job"] = json!("00".repeat(32))), "3 entry");
    assert_eq!(tampered(|items| drop(items.as_array_mut().unwrap().remove(1))), "2 entry");
    assert_eq!(by_python("0190b0de-0000-7000-8000-000000000000", &page), "1 link");
    app.stop().await;
}

#[test]
fn the_program_says_how_it_is_used_and_what_it_cannot_read() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/verify_audit.py");
    let run = |arguments: &[&str]| {
        let output = Command::new("python3").arg(&script).args(arguments).output().unwrap();
        let said = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        assert!(!said.contains("Traceback"), "{said}");
        (output.status.code(), said)
    };
    let (code, said) = run(&["--help"]);
    assert!(code == Some(0) && said.contains("--against SEALS") && said.contains("JOB_ID"), "{said}");
    let (code, said) = run(&["default", "", "/no/such/file"]);
    assert!(code == Some(2) && said.starts_with("not found out: "), "{said}");
    assert_eq!(run(&[]).0, Some(2));
    assert_eq!(run(&["default", ""]), (Some(0), "intact 0 -\n".to_owned()));
}

/// What a purge took away is no break for it either; what is changed afterwards is.
#[tokio::test]
async fn python_agrees_after_a_purge() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    app.iteration(&job).await;
    super::purges::purged(&app, &job).await;
    let page = app.get(&format!("{job}/audit")).await.expect(200).json();
    let id = job.rsplit('/').next().unwrap();
    assert_eq!((page["items"][0].get("actor"), &page["items"][2]["actor"]), (None, &json!("anonymous")));
    let head = page["items"][2]["sha256"].as_str().unwrap();
    assert_eq!(by_python(id, &page), format!("intact 3 {head}"));
    let tampered = |change: fn(&mut Value)| {
        let mut page = page.clone();
        change(&mut page["items"]);
        by_python(id, &page)
    };
    assert_eq!(tampered(|items| items[1]["actor"] = json!("other")), "2 entry");
    assert_eq!(tampered(|items| items[1]["peer"] = json!("other")), "3 content");
    assert_eq!(tampered(|items| items[1]["sha256"] = json!("00".repeat(32))), "3 link");
    assert_eq!(tampered(|items| drop(items.as_array_mut().unwrap().pop())), "3 entry");
    assert_eq!(tampered(|items| items[2]["contents"]["found"] = json!("00".repeat(32))), "3 entry");
    let own = app.get("/v1/audit").await.expect(200).json();
    assert_eq!(own["items"][0]["target"], json!(job));
    assert!(by_python("", &own).starts_with("intact 1 "), "{}", by_python("", &own));
    app.stop().await;
}

fn by_python(job: &str, page: &Value) -> String {
    by_python_with(&[], job, page)
}

/// What the program prints, be it that it does not take the seals.
pub fn by_python_with(options: &[&str], job: &str, page: &Value) -> String {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("page.json");
    std::fs::write(&file, page.to_string()).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/verify_audit.py");
    let output = Command::new("python3").arg(script).args(options).args(["default", job]).arg(file).output();
    let output = output.expect("python3 is there");
    String::from_utf8([output.stdout, output.stderr].concat()).unwrap().trim().to_owned()
}
