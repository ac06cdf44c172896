//! Each kind of request that may be answered later, as the document has them: what is answered, and
//! what is stored, is what the plain request is answered and stores.

use std::collections::BTreeSet;

use flankfit::{api::examples::REQUEST_EXAMPLES, http::openapi::openapi_json};
use reqwest::{
    Method, RequestBuilder,
    multipart::{Form, Part},
};
use serde_json::{Value, json};

use super::{alike, begun, later, masked, result, same, slow_iteration, study};
use crate::{
    gears::import::file,
    jobs::app::{TestApp, send},
};

/// What is sent.
enum Body {
    Json(fn() -> Value),
    Form(fn() -> Form),
}

use Body::Json;

/// Operations of the document, their paths, and something that takes computing.
const KINDS: [(&str, &str, Body); 13] = [
    ("create_fit", "/v1/fits", Json(|| example("fit_least_trimmed"))),
    ("study_randomization", "/v1/studies/randomization", Json(|| study(300))),
    ("simulate_closed_loop", "/v1/simulations/closed-loop", Json(|| with("closed_loop", "store", json!(false)))),
    ("simulate_closed_loop", "/v1/simulations/closed-loop", Json(|| with("closed_loop", "store", json!(true)))),
    ("create_surface", "/v1/surfaces", Json(|| example("surface_scattered"))),
    ("sections_of_surface", "/v1/surfaces/sections", Json(|| example("surface_sections"))),
    ("export_surface", "/v1/surfaces/export", Json(|| example("surface_export"))),
    ("export_curve", "/v1/curves/export", Json(fine_chain)),
    ("create_iteration", "{job}/iterations", Json(slow_iteration)),
    ("create_iteration", "{job}/iterations", Body::Form(measured_nodes)),
    ("create_iteration_fit", "{job}/iterations/1/fits", Json(|| example("refit"))),
    ("create_iteration_surface", "{job}/iterations/1/surfaces", Json(|| example("iteration_surface"))),
    ("import_iteration", "{job}/import", Body::Form(testers_file)),
];

pub fn example(name: &str) -> Value {
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == name).unwrap();
    serde_json::from_str(example.text).unwrap()
}

fn with(name: &str, member: &str, value: Value) -> Value {
    let mut request = example(name);
    request[member] = value;
    request
}

/// More chords than are found in passing.
fn fine_chain() -> Value {
    let mut request = with("curve_export", "format", json!("csv"));
    request["tolerance"] = json!(1e-9);
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
    async fn request(&self, app: &TestApp, path: &str) -> RequestBuilder {
        let request = app.request(Method::POST, path);
        match self {
            Json(body) => request.json(&body()),
            Body::Form(form) => request.multipart(form()),
        }
    }
}

/// The operations that the document offers to answer later.
fn offered() -> BTreeSet<String> {
    let document: Value = serde_json::from_str(openapi_json()).unwrap();
    let posts = document["paths"].as_object().unwrap().values().map(|item| &item["post"]);
    let prefers = |post: &&Value| {
        let mut parameters = post["parameters"].as_array().into_iter().flatten();
        post["responses"]["202"].is_object() && parameters.any(|one| one["in"] == "header" && one["name"] == "Prefer")
    };
    posts.filter(prefers).map(|post| post["operationId"].as_str().unwrap().to_owned()).collect()
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
async fn the_answer_is_the_one_that_the_plain_request_has() {
    let app = TestApp::start().await;
    let [plain_job, later_job] = [measured_job(&app).await, measured_job(&app).await];
    let (mut seen, mut stored_jobs) = (BTreeSet::new(), 0);
    for (id, path, body) in &KINDS {
        println!("{id}");
        let jobs = count_of_jobs(&app).await;
        let plain = send(body.request(&app, &path.replace("{job}", &plain_job)).await).await;
        assert!(plain.status == 200 || plain.status == 201, "{id}: {}", plain.text);
        let by_plain = count_of_jobs(&app).await - jobs;
        let place = path.replace("{job}", &later_job);
        let operation = begun(body.request(&app, &place).await.header("Prefer", "respond-async")).await;
        let answer = result(&app, &operation).await;
        // what tells of no job and of no time is the same to the byte
        let hold = if masked(&plain.text) == plain.text { same } else { alike };
        hold(&answer, &plain);
        // its answer stays the same, however often it is asked for
        same(&result(&app, &operation).await, &answer);
        let told = app.get(&operation).await.expect(200).json();
        assert_eq!(
            (&told["state"], &told["progress"], &told["status"]),
            (&json!("succeeded"), &json!(1.0), &json!(plain.status.as_u16()))
        );
        assert_eq!((&told["attempts"], told["ended_at"].is_string()), (&json!(1), true), "{told}");
        assert_eq!(told["request"], format!("POST {place}"));
        // and so is what there is then
        assert_eq!(count_of_jobs(&app).await - jobs, 2 * by_plain, "{id}");
        stored_jobs += by_plain;
        for list in ["trace", "iterations/1/fits", "iterations/1/records"] {
            let [plain, later] = [&plain_job, &later_job].map(|job| format!("{job}/{list}"));
            alike(&app.get(&later).await.expect(200), &app.get(&plain).await.expect(200));
        }
        seen.insert((*id).to_owned());
    }
    assert_eq!(seen, offered(), "a new one needs a line here");
    assert!(stored_jobs > 0, "the closed loop stores jobs");
    for job in [plain_job, later_job] {
        assert_eq!(app.get(&crate::jobs::audit::verify_of(&job)).await.expect(200).json()["intact"], true);
    }
}

/// The requests of which docs/how-to/operations.md says so.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_takes_no_computing_is_answered_at_once() {
    let app = TestApp::start().await;
    let quick = [("/v1/fits", "fit_curve"), ("/v1/surfaces", "surface_grid"), ("/v1/curves/export", "curve_export")];
    for (path, name) in quick {
        let answer = send(later(&app, path, &example(name))).await.expect(200);
        assert_eq!(answer.header("preference-applied"), None, "{name}");
    }
    assert_eq!(app.get("/v1/operations").await.expect(200).json()["items"], json!([]), "nothing was begun");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn operations_are_listed_in_pages_newest_first() {
    let app = TestApp::start().await;
    let mut places = Vec::new();
    for repetitions in [40, 50, 60, 70] {
        places.push(begun(later(&app, "/v1/studies/randomization", &study(repetitions))).await);
    }
    places.reverse();
    let seen = |page: &Value| -> Vec<String> {
        let items = page["items"].as_array().unwrap().iter();
        items.map(|item| format!("/v1/operations/{}", item["id"].as_str().unwrap())).collect()
    };
    let list = app.get("/v1/operations?limit=3").await.expect(200).json();
    assert_eq!(seen(&list), places[..3]);
    let rest = app.get(&format!("/v1/operations?cursor={}", list["next_cursor"].as_str().unwrap())).await.json();
    assert_eq!((seen(&rest), rest.get("next_cursor")), (places[3..].to_vec(), None));
}
