//! Each operation that is offered with progress: the result, and what is stored, are those of the
//! plain request.

use std::collections::BTreeSet;

use flankfit::{api::examples::REQUEST_EXAMPLES, http::openapi::openapi_json};
use jiff::Timestamp;
use reqwest::{
    Method, RequestBuilder,
    multipart::{Form, Part},
};
use serde_json::{Value, json};
use uuid::Uuid;

use super::{eager, result, slow_iteration, study, with_progress};
use crate::{
    gears::import::file,
    jobs::app::{TestApp, send},
};

/// Body of a request.
enum Body {
    Json(fn() -> Value),
    Form(fn() -> Form),
}

use Body::Json;

/// Operations of the document, their paths, and something that takes computing.
const KINDS: [(&str, &str, Body); 11] = [
    ("create_fit", "/v1/fits", Json(|| example("fit_least_trimmed"))),
    ("study_randomization", "/v1/studies/randomization", Json(|| study(300))),
    ("simulate_closed_loop", "/v1/simulations/closed-loop", Json(|| closed_loop(false))),
    ("simulate_closed_loop", "/v1/simulations/closed-loop", Json(|| closed_loop(true))),
    ("create_surface", "/v1/surfaces", Json(|| example("surface_scattered"))),
    ("sections_of_surface", "/v1/surfaces/sections", Json(|| example("surface_sections"))),
    ("create_iteration", "{job}/iterations", Json(slow_iteration)),
    ("create_iteration", "{job}/iterations", Body::Form(measured_nodes)),
    ("create_iteration_fit", "{job}/iterations/1/fits", Json(|| example("refit"))),
    ("create_iteration_surface", "{job}/iterations/1/surfaces", Json(|| example("iteration_surface"))),
    ("import_iteration", "{job}/import", Body::Form(testers_file)),
];

fn example(name: &str) -> Value {
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == name).unwrap();
    serde_json::from_str(example.text).unwrap()
}

fn closed_loop(store: bool) -> Value {
    let mut request = example("closed_loop");
    request["store"] = json!(store);
    request
}

fn measured_nodes() -> Form {
    let spec = r#"{"model":{"type":"polynomial","degree":1},"estimator":{"type":"lp","p":1.5}}"#;
    let rows: String = (0..20).map(|k| format!("{k},{}\n", f64::from(k * k % 7) + 0.5 * f64::from(k))).collect();
    Form::new().part("spec", Part::text(spec)).part("nodes", Part::text(format!("x,y\n{rows}")))
}

fn testers_file() -> Form {
    Form::new().part("file", Part::bytes(file(true)).file_name("1.mka"))
}

impl Body {
    fn request(&self, app: &TestApp, path: &str) -> RequestBuilder {
        let request = app.request(Method::POST, path);
        match self {
            Json(body) => request.json(&body()),
            Body::Form(form) => request.multipart(form()),
        }
    }
}

/// The operations that the document offers with progress.
fn offered() -> BTreeSet<String> {
    let document: Value = serde_json::from_str(openapi_json()).unwrap();
    let posts = document["paths"].as_object().unwrap().values().map(|item| &item["post"]);
    let events = |post: &&Value| post.pointer("/responses/200/content/text~1event-stream").is_some();
    posts.filter(events).map(|post| post["operationId"].as_str().unwrap().to_owned()).collect()
}

/// A text without ids, digests and times, which differ between two jobs.
fn masked(text: &str) -> String {
    let is_word = |c: char| c.is_ascii_alphanumeric() || "-:.".contains(c);
    let without = |piece: &str| {
        let word = piece.trim_end_matches(|c: char| !is_word(c));
        let is_digest = word.len() == 64 && word.bytes().all(|byte| byte.is_ascii_hexdigit());
        let is_id = word.len() == 36 && Uuid::try_parse(word).is_ok();
        let differs = is_digest || is_id || word.parse::<Timestamp>().is_ok();
        if differs { piece.replacen(word, "*", 1) } else { piece.to_owned() }
    };
    text.split_inclusive(|c: char| !is_word(c)).map(without).collect()
}

/// A job with an iteration.
async fn measured_job(app: &TestApp) -> String {
    let job = app.job().await;
    app.post(&format!("{job}/iterations"), &example("iteration")).await.expect(201);
    job
}

async fn count_of_jobs(app: &TestApp) -> usize {
    app.get("/v1/jobs?limit=200").await.expect(200).json()["items"].as_array().unwrap().len()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_result_is_the_body_of_the_plain_answer() {
    let app = eager().await;
    let [plain_job, other_job] = [measured_job(&app).await, measured_job(&app).await];
    let (mut seen, mut stored_jobs) = (BTreeSet::new(), 0);
    for (id, path, body) in &KINDS {
        println!("{id}");
        let jobs = count_of_jobs(&app).await;
        let plain = send(body.request(&app, &path.replace("{job}", &plain_job))).await;
        assert!(plain.status == 200 || plain.status == 201, "{id}: {}", plain.text);
        let by_plain = count_of_jobs(&app).await - jobs;
        let data = result(with_progress(body.request(&app, &path.replace("{job}", &other_job)))).await;
        let expected = masked(&plain.text);
        if expected == plain.text {
            assert!(data == plain.text, "{id}: {data}\n{}", plain.text);
        }
        assert!(masked(&data) == expected, "{id}: {data}\n{}", plain.text);
        assert_eq!(count_of_jobs(&app).await - jobs, 2 * by_plain, "{id}");
        stored_jobs += by_plain;
        for list in ["trace", "iterations/1/fits", "iterations/1/records"] {
            let [plain, other] = [&plain_job, &other_job].map(|job| format!("{job}/{list}"));
            let [plain, other] = [app.get(&plain).await.expect(200), app.get(&other).await.expect(200)];
            assert_eq!(masked(&other.text), masked(&plain.text), "{id}: {list}");
        }
        seen.insert((*id).to_owned());
    }
    assert_eq!(seen, offered(), "a new one needs a line here");
    assert!(stored_jobs > 0, "the closed loop stores jobs");
    while app.state().budget.held() > 0 {
        tokio::task::yield_now().await;
    }
}
