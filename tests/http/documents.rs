//! The first request of README.md and the program of the tutorial, against a server.

use std::{fs, path::Path, process::Command};

use serde_json::Value;

use crate::harness::{TestApp, send};

fn document(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap()
}

/// The first block of code in a language.
fn block<'a>(text: &'a str, language: &str) -> &'a str {
    let (_, rest) = text.split_once(&format!("```{language}\n")).unwrap();
    rest.split_once("```").unwrap().0
}

/// True if the response has all that is quoted, numbers to two decimals.
fn holds(quoted: &Value, response: &Value) -> bool {
    match (quoted, response) {
        (Value::Object(quoted), _) => quoted.iter().all(|(name, value)| holds(value, &response[name])),
        (Value::Array(quoted), Value::Array(response)) => {
            quoted.len() == response.len() && quoted.iter().zip(response).all(|(one, other)| holds(one, other))
        }
        (Value::Number(quoted), Value::Number(response)) => {
            (quoted.as_f64().unwrap() - response.as_f64().unwrap()).abs() < 0.005_001
        }
        _ => quoted == response,
    }
}

#[tokio::test]
async fn the_readme_quotes_the_response() {
    let app = TestApp::start().await;
    let readme = document("README.md");
    let quoted: Value = serde_json::from_str(block(&readme, "json")).unwrap();
    let path = "/v1/gears/flank-surface";
    let example = "examples/requests/gear_flank_surface.json";
    assert!(readme.contains(path) && readme.contains(example));
    let response = send(app.post(path, document(example))).await.json();
    assert!(holds(&quoted, &response), "{response:#}");
    app.stop().await;
}

#[tokio::test]
async fn the_program_of_the_tutorial_closes_the_loop() {
    let app = TestApp::start().await;
    let page = document("docs/tutorial/close-the-loop.md");
    let mut python = Command::new("python3");
    python.args(["-c", block(&page, "python"), &app.url("")]);
    let run = tokio::task::spawn_blocking(move || python.output()).await.unwrap().unwrap();
    let printed = String::from_utf8(run.stdout).unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    // the page quotes it, from its first to its last line
    assert_eq!(printed.trim(), block(&page, "text").trim());
    app.stop().await;
}
