//! Properties of every operation of the contract, one after the other: its query, the forms of its
//! responses, its idempotency key.

use std::collections::BTreeSet;

use flankfit::http::openapi::openapi_json;
use reqwest::{Method, RequestBuilder};
use serde_json::Value;

use crate::harness::{Answer, TestApp, send};

const NOBODY: &str = "0190b0de-0000-7000-8000-000000000000";

/// An operation as the contract has it.
struct Operation {
    id: String,
    method: Method,
    path: String,
    declared: Value,
}

impl Operation {
    fn all() -> Vec<Self> {
        let document: Value = serde_json::from_str(openapi_json()).unwrap();
        let mut all = Vec::new();
        for (path, item) in document["paths"].as_object().unwrap() {
            for (method, declared) in item.as_object().unwrap() {
                all.push(Operation {
                    id: declared["operationId"].as_str().unwrap().to_owned(),
                    method: method.to_uppercase().parse().unwrap(),
                    path: path.clone(),
                    declared: declared.clone(),
                });
            }
        }
        assert!(all.len() > 50, "{}", all.len());
        all
    }

    fn parameters(&self, place: &str) -> Vec<&str> {
        let all = self.declared["parameters"].as_array().into_iter().flatten();
        all.filter(|parameter| parameter["in"] == place).map(|one| one["name"].as_str().unwrap()).collect()
    }

    /// Media types of its successful responses.
    fn media(&self) -> BTreeSet<&str> {
        let of_answers = |(status, _): &(&String, &Value)| status.starts_with('2');
        let good = self.declared["responses"].as_object().unwrap().iter().filter(of_answers);
        good.filter_map(|(_, response)| response["content"].as_object()).flatten().map(|(media, _)| &**media).collect()
    }

    /// A request of nothing that is there.
    fn request(&self, app: &TestApp, query: &str) -> RequestBuilder {
        let ids = ["job_id", "stream_id", "fit_id", "record_id"];
        let path = ids.iter().fold(self.path.clone(), |path, id| path.replace(&format!("{{{id}}}"), NOBODY));
        let path = path.replace("{number}", "1").replace("{key_id}", "0123456789abcdef").replace("{tenant}", "nobody");
        assert!(!path.contains('{'), "{path}");
        // events of all jobs would come without end: after an id that is none there are none
        let query = if self.id == "get_events" && query.is_empty() { "?last_event_id=none" } else { query };
        app.client.request(self.method.clone(), app.url(&format!("{path}{query}")))
    }
}

/// The first details of a 422 with their pointers.
#[track_caller]
fn details(answer: &Answer) -> Vec<(String, String)> {
    let body = answer.problem(422, "invalid_request");
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    body["errors"].as_array().unwrap().iter().map(|e| (text(&e["pointer"]), text(&e["detail"]))).collect()
}

/// Bytes that are not UTF-8 are refused in every place of a URL that takes a value.
#[tokio::test]
async fn invalid_utf_8_in_urls_is_a_client_error() {
    let app = TestApp::start().await;
    let accepting = |request: RequestBuilder, accept: &str| request.header("accept", accept);
    let mut asked = 0;
    for operation in Operation::all() {
        let places: Vec<&str> = operation.path.split('/').filter(|part| part.starts_with('{')).collect();
        let wrong_path = |place: &str| Operation {
            id: operation.id.clone(),
            method: operation.method.clone(),
            path: operation.path.replace(place, "%ff"),
            declared: operation.declared.clone(),
        };
        let offers_events = operation.media().contains("text/event-stream");
        for accept in ["*/*", "text/event-stream"].into_iter().take(1 + usize::from(offers_events)) {
            for place in &places {
                let wrong = wrong_path(place);
                let request = wrong.request(&app, "").header("content-type", "application/json").body("{}");
                let answer = send(accepting(request, accept)).await;
                let status = answer.status.as_u16();
                assert!([400, 404].contains(&status), "{} {}: {}", wrong.id, wrong.path, answer.text);
                asked += 1;
            }
            for name in operation.parameters("query").into_iter().chain(["%ff"]) {
                let request = operation.request(&app, &format!("?{name}=%ff"));
                let request = request.header("content-type", "application/json").body("{}");
                send(accepting(request, accept)).await.problem(400, "malformed_request");
                asked += 1;
            }
        }
    }
    assert!(asked > 200, "{asked}");
    app.stop().await;
}

#[tokio::test]
async fn query_parameters_are_known_and_occur_once() {
    let app = TestApp::start().await;
    for operation in Operation::all() {
        let known = operation.parameters("query");
        let answer = send(operation.request(&app, "?no_such=1&other%2Fone")).await;
        let [(first, detail), (second, _)] = &details(&answer)[..] else { panic!("{}: {}", operation.id, answer.text) };
        assert_eq!((first.as_str(), second.as_str()), ("/no_such", "/other~1one"), "{}", operation.id);
        assert!(known.iter().all(|name| detail.contains(&format!("`{name}`"))), "{}: {detail}", operation.id);
        assert_eq!(detail.contains("has none"), known.is_empty(), "{}: {detail}", operation.id);
        for name in known {
            let answer = send(operation.request(&app, &format!("?{name}=1&{name}=1"))).await;
            assert_eq!(details(&answer)[0].0, format!("/{name}"), "{}", operation.id);
            let answer = send(operation.request(&app, &format!("?{name}=1"))).await;
            assert!(
                !answer.text.contains("no such query parameter") && !answer.text.contains("twice"),
                "{}",
                answer.text
            );
        }
    }
    // a GET without its body is a GET
    let head = app.client.head(app.url("/v1/jobs?no_such=1"));
    assert_eq!(send(head).await.status, 422);
    assert_eq!(send(app.get("/openapi.json?no_such=1")).await.status, 200, "what is no operation has no contract");
    app.stop().await;
}

#[tokio::test]
async fn unavailable_media_types_get_406() {
    let app = TestApp::start().await;
    let mut single = 0;
    for operation in Operation::all() {
        let media = operation.media();
        let asked = async |accept: &str| send(operation.request(&app, "").header("accept", accept)).await;
        // events come without end, to whom they are sent
        if operation.id != "get_job_events" {
            assert_ne!(send(operation.request(&app, "")).await.status, 406, "{}", operation.id);
        }
        for accept in ["*/*", "image/png, */*;q=0.1"] {
            assert_ne!(asked(accept).await.status, 406, "{} {accept}", operation.id);
        }
        for one in &media {
            assert_ne!(asked(one).await.status, 406, "{} {one}", operation.id);
            assert_ne!(asked(&format!("text/html, {one};q=0.5")).await.status, 406, "{} {one}", operation.id);
        }
        let refusing = ["image/png", "application/json", "text/csv", "text/plain;q=0, application/problem+json"];
        for accept in refusing.into_iter().filter(|accept| !media.contains(accept)) {
            let answer = asked(accept).await;
            if media.is_empty() {
                assert_ne!(answer.status, 406, "{} {accept}", operation.id);
                continue;
            }
            let detail = answer.problem(406, "not_acceptable")["detail"].to_string();
            assert!(media.iter().all(|media| detail.contains(media)), "{}: {detail}", operation.id);
            single += usize::from(media.len() == 1);
        }
    }
    assert!(single > 100, "{single}");
    // also where there is something to answer
    let answer = send(app.get("/v1/jobs").header("accept", "text/csv")).await;
    answer.problem(406, "not_acceptable");
    assert_eq!(send(app.get("/v1/jobs").header("accept", "text/csv, application/*;q=0.1")).await.status, 200);
    app.stop().await;
}

/// A response as it is kept: a secret is returned once.
fn without_secret(text: &str) -> String {
    let Some(from) = text.find(r#","key":"ffk_"#) else { return text.to_owned() };
    let to = from + r#","key":""#.len() + 93 + 1;
    format!("{}{}", &text[..from], &text[to..])
}

/// A key is for one request: of every operation that takes one, another body is refused, and the
/// same one gets the first response again.
#[tokio::test]
async fn a_key_is_for_one_body() {
    let app = TestApp::start().await;
    let example = |operation: &Operation, name: &str| {
        operation.declared["requestBody"]["content"]["application/json"]["examples"][name]["value"].to_string()
    };
    let operations = Operation::all();
    let named = |id: &str| operations.iter().find(|operation| operation.id == id).unwrap();
    let job = send(app.post("/v1/jobs", example(named("create_job"), "job"))).await.header("location").to_owned();
    let made = example(named("create_iteration"), "iteration");
    assert_eq!(send(app.post(&format!("{job}/iterations"), made)).await.status, 201);
    let stream = send(app.post(&format!("{job}/streams"), example(named("create_stream"), "stream"))).await;
    let stream = stream.header("location").to_owned();
    let key = send(app.post("/v1/keys", example(named("create_key"), "key"))).await.json()["id"].clone();
    let key = key.as_str().unwrap();
    let mut keyed: Vec<&Operation> =
        operations.iter().filter(|operation| operation.parameters("header").contains(&"Idempotency-Key")).collect();
    // what is finished takes no more nodes, and a purged job nothing at all
    keyed.sort_by_key(|operation| ["finish_stream", "purge_job"].iter().position(|id| *id == operation.id));
    let (mut seen, mut secrets) = (BTreeSet::new(), 0);
    for operation in &keyed {
        let path = operation.path.replace("/v1/jobs/{job_id}", &job).replace("/v1/streams/{stream_id}", &stream);
        let path = path.replace("{number}", "1").replace("{key_id}", key);
        let post = async |body: &str| send(app.post(&path, body.to_owned()).header("idempotency-key", "one key")).await;
        let examples = &operation.declared["requestBody"]["content"]["application/json"]["examples"];
        let Some((_, shown)) = examples.as_object().and_then(|examples| examples.iter().next()) else { continue };
        let body = shown["value"].to_string();
        let first = post(&body).await;
        assert!(first.status.is_success() && first.header("idempotency-replayed").is_empty(), "{}", first.text);
        let again = post(&body).await;
        let kept = without_secret(&first.text);
        assert_eq!((&again.text, again.header("idempotency-replayed")), (&kept, "true"), "{}", operation.id);
        secrets += usize::from(kept != first.text);
        for other in [format!("{body} "), "{}".to_owned(), String::new(), "no JSON".to_owned()] {
            post(&other).await.problem(422, "idempotency_key_reused");
        }
        for response in operation.declared["responses"].as_object().unwrap().iter().filter(|r| r.0.starts_with('2')) {
            assert!(response.1["headers"]["Idempotency-Replayed"].is_object(), "{}", operation.id);
        }
        seen.insert(operation.id.as_str());
    }
    assert_eq!(secrets, 3, "a key, another one in its place, and the first of a tenant");
    // a form has a test of its own
    let all: BTreeSet<&str> = keyed.iter().map(|operation| operation.id.as_str()).collect();
    assert_eq!(all.difference(&seen).copied().collect::<Vec<_>>(), ["import_iteration"]);
    app.stop().await;
}

/// A replay says nothing, so nothing that is said passes unseen.
#[tokio::test]
async fn a_replay_refuses_a_body() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", r#"{"name":"w"}"#)).await.header("location").to_owned();
    let made = send(app.post(&format!("{job}/iterations"), crate::harness::CURVE)).await.json();
    let place = format!("{job}/iterations/1/fits/{}/replay", made["fits"][0]["id"].as_str().unwrap());
    for body in ["", " ", "{}"] {
        assert_eq!(send(app.post(&place, body)).await.text, r#"{"identical":true}"#, "{body:?}");
    }
    assert_eq!(send(app.client.post(app.url(&place))).await.status, 200, "without a media type");
    assert_eq!(send(app.post(&place, r#"{"model":1,"include":[]}"#)).await.pointers(), ["/model", "/include"]);
    send(app.post(&place, "{")).await.problem(400, "malformed_body");
    let other = app.client.post(app.url(&place)).header("content-type", "text/csv").body("{}");
    send(other).await.problem(415, "unsupported_media_type");
    app.stop().await;
}

/// A page of one list does not begin where another one ended.
#[tokio::test]
async fn cursors_belong_to_their_list() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", r#"{"name":"w"}"#)).await.header("location").to_owned();
    send(app.post("/v1/jobs", r#"{"name":"v"}"#)).await;
    let refit = r#"{"model":{"type":"polynomial","degree":2}}"#;
    for _ in 0..2 {
        assert_eq!(send(app.post(&format!("{job}/iterations"), crate::harness::CURVE)).await.status, 201);
        assert_eq!(send(app.post(&format!("{job}/iterations/1/fits"), refit)).await.status, 201);
        let curve = r#"{"method":{"type":"cubic_spline","ends":{"type":"natural"}}}"#;
        let kept = send(app.post(&format!("{job}/iterations/1/curves"), curve)).await;
        assert_eq!(kept.status, 201, "{}", kept.text);
    }
    for name in ["one", "two"] {
        // what is done in between is sealed by itself
        let sealing = app.state.jobs.seal_audit(None).await;
        assert!(sealing.is_ok(), "{sealing:?}");
        let key = format!(r#"{{"name":"{name}","role":"reader"}}"#);
        assert_eq!(send(app.post("/v1/keys", key)).await.status, 201);
        assert_eq!(send(app.post("/v1/tenants", format!(r#"{{"name":"{name}"}}"#))).await.status, 201);
    }
    let lists = [
        ("/v1/jobs".to_owned(), "jobs"),
        (format!("{job}/trace"), "iterations"),
        (format!("{job}/iterations/1/fits"), "fits"),
        (format!("{job}/iterations/1/records"), "records"),
        ("/v1/audit".to_owned(), "entries of the audit"),
        ("/v1/keys".to_owned(), "keys"),
        ("/v1/tenants".to_owned(), "tenants"),
        ("/v1/audit/seals".to_owned(), "seals"),
    ];
    for (list, items) in &lists {
        let page = send(app.get(&format!("{list}?limit=1"))).await.json();
        let cursor = page["next_cursor"].as_str().unwrap_or_else(|| panic!("{page}"));
        for (other, wanted) in &lists {
            let answer = send(app.get(&format!("{other}?cursor={cursor}"))).await;
            if other == list {
                assert_eq!(answer.status, 200, "{}", answer.text);
                continue;
            }
            let details = details(&answer);
            assert_eq!(details[0].0, "/cursor");
            assert!(details[0].1.contains(items) && details[0].1.contains(wanted), "{}", details[0].1);
        }
    }
    app.stop().await;
}
