//! Archives of jobs whose folder takes no files: what is said when the server starts, and later.

use std::{
    fs,
    path::Path,
    time::{Duration, Instant},
};

use reqwest::{Client, RequestBuilder};
use serde_json::Value;

use super::talkative::Talkative;
use crate::{
    harness::{Answer, send},
    jobs::purges::noisy,
};

/// For so long a line of the log is waited for.
const PATIENCE: Duration = Duration::from_secs(60);

/// A server and who asks it.
struct Asked {
    server: Talkative,
    client: Client,
}

impl Asked {
    fn new(server: Talkative) -> Self {
        Asked { server, client: Client::builder().no_proxy().build().unwrap() }
    }

    fn post(&self, path: &str, body: &Value) -> RequestBuilder {
        let request = self.client.post(format!("{}{path}", self.server.base));
        request.header("content-type", "application/json").body(body.to_string())
    }

    /// What is answered to who asks for the archive of a job, which is short or is not.
    async fn archive(&self, count: u32) -> Answer {
        let job = send(self.post("/v1/jobs", &serde_json::json!({"name": "wheel"}))).await;
        let job = format!("/v1/jobs/{}", job.json()["id"].as_str().unwrap());
        let stored = send(self.post(&format!("{job}/iterations"), &noisy(count))).await;
        assert_eq!(stored.status, 201, "{}", stored.text);
        send(self.client.post(format!("{}{job}/archive", self.server.base))).await
    }

    /// A line of the log that has all of these.
    async fn hears(&self, all: &[&str]) {
        let begun = Instant::now();
        loop {
            let said = self.server.said();
            if said.lines().any(|line| all.iter().all(|part| line.contains(part))) {
                return;
            }
            assert!(begun.elapsed() < PATIENCE, "{all:?}");
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    }
}

/// It is no fault of the store, and no other try helps.
async fn refuses_what_is_long(asked: &Asked, folder: &Path) {
    let refused = asked.archive(150_000).await;
    let problem = refused.problem(500, "internal");
    assert!(problem["detail"].as_str().unwrap().contains("folder for archives"), "{problem}");
    assert!(!refused.text.contains(folder.to_str().unwrap()), "{problem}");
    assert_eq!(refused.header("retry-after"), "");
    let id = problem["request_id"].as_str().unwrap();
    asked.hears(&[id, "\"cause\"", &format!("{}: ", folder.display())]).await;
}

#[tokio::test]
async fn a_folder_that_is_gone_is_named_in_the_log() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("archives");
    fs::create_dir(&folder).unwrap();
    let arguments = ["--archive-dir", folder.to_str().unwrap()];
    let asked = Asked::new(Talkative::start(&place.path().join("test.db"), &arguments));
    fs::remove_dir(&folder).unwrap();
    refuses_what_is_long(&asked, &folder).await;
    assert_eq!(asked.archive(20).await.status, 200);
}

#[tokio::test]
async fn a_place_for_temporary_files_that_takes_none_is_told_at_the_start() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("nowhere");
    let environment = [("TMPDIR", folder.to_str().unwrap())];
    let asked = Asked::new(Talkative::within(&environment, &place.path().join("test.db"), &[]));
    asked.hears(&["WARN", folder.to_str().unwrap(), "--archive-dir"]).await;
    refuses_what_is_long(&asked, &folder).await;
}
