//! The line that each request has in the log.

use std::time::{Duration, Instant};

use reqwest::Client;
use serde_json::Value;
use tokio::time::sleep;

use super::talkative::Talkative;

const PATIENCE: Duration = Duration::from_secs(60);

/// Level, route and status of the logged responses.
fn answered(said: &str) -> Vec<(String, String, u64)> {
    let lines = said.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let answered = lines.filter(|line| line["message"] == "answered");
    answered
        .map(|line| {
            let [level, route] = ["level", "route"].map(|field| line[field].as_str().unwrap().to_owned());
            (level, route, line["status"].as_u64().unwrap())
        })
        .collect()
}

#[tokio::test]
async fn checks_that_go_well_are_logged_for_debugging_alone() {
    for (level, written, quiet) in [("info", "INFO", true), ("debug", "DEBUG", false)] {
        let folder = tempfile::tempdir().unwrap();
        let server = Talkative::logging(level, &[], &folder.path().join("test.db"), &[]);
        let client = Client::builder().no_proxy().build().unwrap();
        let mut expected = Vec::new();
        for (path, is_check) in [
            ("/healthz", true),
            ("/readyz", true),
            ("/readyz?for=compute", true),
            ("/metrics", true),
            // what is wrong, and what others ask
            ("/readyz?for=canary", false),
            ("/v1/jobs", false),
        ] {
            let answer = client.get(format!("{}{path}", server.base)).send().await.unwrap();
            assert_eq!(answer.status().is_success(), path != "/readyz?for=canary", "{path}");
            if !(quiet && is_check) {
                let route = path.split('?').next().unwrap();
                expected.push((written.to_owned(), route.to_owned(), u64::from(answer.status().as_u16())));
            }
        }
        // lines are written after the responses
        let begun = Instant::now();
        while answered(&server.said()).len() < expected.len() && begun.elapsed() < PATIENCE {
            sleep(Duration::from_millis(20)).await;
        }
        assert_eq!(answered(&server.end()), expected, "{level}");
    }
}
