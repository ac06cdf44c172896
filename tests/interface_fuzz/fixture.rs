//! A service with something stored in it, so that requests by id find what they name.

use std::time::Duration;

use axum::{Router, body::Body, http};
use flankfit::{
    api::examples::REQUEST_EXAMPLES,
    app::App,
    config::{Authentication, ServeSettings},
    http::router,
};
use http_body_util::BodyExt as _;
use hyper::body::Frame;
use serde_json::Value;
use tower::ServiceExt as _;

use super::{node::Node, rng::Rng, spool::Spool};
use std::net::SocketAddr;

/// Seconds that an answer may take before the service gives up.
pub const REQUEST_TIMEOUT: u64 = 4;
/// Things of one kind that are remembered.
const MOST: usize = 24;

pub struct Service {
    pub router: Router,
    pub address: SocketAddr,
    _folder: tempfile::TempDir,
}

impl Service {
    pub async fn start() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let settings = ServeSettings {
            bind: SocketAddr::from(([127, 0, 0, 1], 0)),
            database_url: format!("sqlite://{}", folder.path().join("fuzz.db").display()),
            workers: 1,
            auth: Authentication::Off,
            request_timeout: REQUEST_TIMEOUT,
            body_timeout: 3,
            shutdown_grace: 0,
            ..ServeSettings::default()
        };
        let app = App::start(settings).await.expect("the service starts");
        let (router, address) = (router(app.state().clone()), app.address().expect("an address"));
        tokio::spawn(app.serve(std::future::pending()));
        Service { router, address, _folder: folder }
    }

    /// Status, headers and body of an answer whose body ends; no piece of it is held here.
    pub async fn spool(&self, request: http::Request<Body>) -> (u16, http::HeaderMap, Spool) {
        let response = self.router.clone().oneshot(request).await.expect("a router does not fail");
        let (head, mut body) = response.into_parts();
        let endless =
            head.headers.get("content-type").is_some_and(|media| media.as_bytes().starts_with(b"text/event-stream"));
        // of what has no end only what is there already is looked at
        let wait = if endless { Duration::from_millis(20) } else { Duration::MAX };
        let mut spool = Spool::default();
        while let Ok(Some(frame)) = tokio::time::timeout(wait, body.frame()).await {
            match frame.map(Frame::into_data) {
                Ok(Ok(data)) => spool.put(&data),
                Ok(Err(_trailers)) => {}
                Err(error) => {
                    spool.put(format!("the answer ends early: {error}").as_bytes());
                    break;
                }
            }
            if endless {
                break;
            }
        }
        (head.status.as_u16(), head.headers, spool)
    }

    /// Response to a request without errors, with a body unless that is empty.
    pub async fn ask(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &str,
    ) -> (u16, http::HeaderMap, Vec<u8>) {
        let mut request = http::Request::builder().method(method).uri(path).header("host", "localhost");
        let json = [("content-type", "application/json")];
        for (name, value) in headers.iter().chain(json.iter().filter(|_| !body.is_empty())) {
            request = request.header(*name, *value);
        }
        let request = request.body(Body::from(body.to_owned())).expect("a request");
        let (status, headers, answer) = self.spool(request).await;
        (status, headers, answer.into_bytes())
    }

    /// Response that must be successful: the stock of a batch.
    async fn make(&self, method: &str, path: &str, body: &str) -> Value {
        let (status, _, answer) = self.ask(method, path, &[], body).await;
        let text = String::from_utf8(answer).expect("JSON is UTF-8");
        assert!((200..300).contains(&status), "{method} {path}: {status} {text}");
        serde_json::from_str(&text).unwrap_or(Value::Null)
    }
}

/// The first example of what an operation takes.
pub fn example(operation: &str) -> String {
    let found = REQUEST_EXAMPLES.iter().find(|example| example.operation_id == operation);
    found.expect("an example").text.to_owned()
}

/// One stored thing and those above it.
#[derive(Clone, Debug, Default)]
pub struct Owner {
    job: String,
    number: u64,
    fit: String,
    record: String,
    stream: String,
    key: String,
}

/// Resources known to be stored.
#[derive(Debug, Default)]
pub struct Stored {
    jobs: Vec<String>,
    iterations: Vec<(String, u64)>,
    fits: Vec<(String, u64, String)>,
    records: Vec<(String, u64, String)>,
    streams: Vec<String>,
    keys: Vec<String>,
    tags: Vec<String>,
}

fn remember<T: PartialEq>(list: &mut Vec<T>, item: T) {
    if !list.contains(&item) {
        if list.len() == MOST {
            list.remove(MOST / 2);
        }
        list.push(item);
    }
}

impl Stored {
    /// Stores a job with two iterations, refits, records and streams, by the examples.
    pub async fn fill(service: &Service) -> Self {
        let mut stored = Stored::default();
        let mut make = async |method: &str, path: String, body: String| {
            let made = service.make(method, &path, &body).await;
            stored.learn(&path, None, &made);
            made
        };
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        let job = make("POST", "/v1/jobs".into(), example("create_job")).await;
        let job = format!("/v1/jobs/{}", text(&job["id"]));
        for _ in 0..2 {
            make("POST", format!("{job}/iterations"), example("create_iteration")).await;
        }
        make("POST", "/v1/keys".into(), example("create_key")).await;
        let first = format!("{job}/iterations/1");
        make("POST", format!("{first}/fits"), example("create_iteration_fit")).await;
        for (operation, name) in [
            ("create_iteration_deviations", "deviations"),
            ("create_iteration_evaluation", "evaluations"),
            ("create_iteration_pitch", "pitch"),
            ("create_iteration_correction", "correction"),
            ("create_applied_changes", "correction/applied"),
            ("create_iteration_curve", "curves"),
            ("create_iteration_surface", "surfaces"),
        ] {
            make("POST", format!("{first}/{name}"), example(operation)).await;
        }
        for (operation, name) in
            [("create_gear_correction", "correction"), ("create_gear_applied_changes", "correction/applied")]
        {
            make("POST", format!("{job}/{name}"), example(operation)).await;
        }
        for finished in [true, false] {
            let stream = make("POST", format!("{job}/streams"), example("create_stream")).await;
            let stream = format!("/v1/streams/{}", text(&stream["id"]));
            make("POST", format!("{stream}/nodes"), example("add_stream_nodes")).await;
            if finished {
                make("POST", format!("{stream}/finish"), example("finish_stream")).await;
            }
        }
        stored
    }

    /// Adds the stored resources in a response.
    pub fn learn(&mut self, path: &str, tag: Option<&str>, answer: &Value) {
        if let Some(tag) = tag {
            remember(&mut self.tags, tag.to_owned());
        }
        if path.starts_with("/v1/keys")
            && let Some(id) = answer["id"].as_str()
        {
            return remember(&mut self.keys, id.to_owned());
        }
        let text = |value: &Value| value.as_str().filter(|text| text.len() == 36).map(str::to_owned);
        let Some(id) = text(&answer["id"]).or_else(|| text(&answer["fit"]["id"])) else {
            return self.learn_iteration(path, answer);
        };
        let parts: Vec<&str> = path.split('?').next().unwrap_or_default().split('/').collect();
        match parts[..] {
            ["", "v1", "jobs"] => remember(&mut self.jobs, id),
            ["", "v1", "jobs", _, "streams"] => remember(&mut self.streams, id),
            ["", "v1", "jobs", job, "iterations", number, kind] => {
                let Ok(number) = number.parse() else { return };
                let owned = (job.to_owned(), number, id);
                let list = if kind == "fits" { &mut self.fits } else { &mut self.records };
                remember(list, owned);
            }
            _ => {}
        }
        self.learn_iteration(path, answer);
    }

    fn learn_iteration(&mut self, path: &str, answer: &Value) {
        let Some(job) = path.strip_prefix("/v1/jobs/").and_then(|rest| rest.split('/').next()) else { return };
        let Some(number) = answer["number"].as_u64() else { return };
        remember(&mut self.iterations, (job.to_owned(), number));
        for fit in answer["fits"].as_array().into_iter().flatten() {
            if let Some(id) = fit["id"].as_str() {
                remember(&mut self.fits, (job.to_owned(), number, id.to_owned()));
            }
        }
    }

    pub fn draw(&self, rng: &mut Rng) -> Owner {
        let mut owner = Owner { number: 1, ..Owner::default() };
        let unknown = || "0190b0de-0000-7000-8000-000000000000".to_owned();
        owner.job = rng.pick(&self.jobs).cloned().unwrap_or_else(unknown);
        (owner.fit, owner.record) = (unknown(), unknown());
        owner.key = rng.pick(&self.keys).cloned().unwrap_or_else(|| "0123456789abcdef".to_owned());
        owner.stream = rng.pick(&self.streams).cloned().unwrap_or_else(unknown);
        let lists = [&self.fits, &self.records];
        if let Some((job, number)) = rng.pick(&self.iterations) {
            (owner.job, owner.number) = (job.clone(), *number);
        }
        for (list, id) in lists.into_iter().zip([&mut owner.fit, &mut owner.record]) {
            let own: Vec<_> =
                list.iter().filter(|(job, number, _)| (job, number) == (&owner.job, &owner.number)).collect();
            if let Some((_, _, found)) = rng.pick(&own) {
                id.clone_from(found);
            }
        }
        owner
    }

    /// Ids in a body become those of stored things, mostly.
    pub fn put_ids(&self, body: &mut Node, rng: &mut Rng) {
        let owner = self.draw(rng);
        body.visit_mut(&mut |node| {
            if let Node::Text(text) = node
                && text.len() == 36
                && text.matches('-').count() == 4
                && rng.percent(80)
            {
                text.clone_from(&owner.fit);
            }
        });
    }

    pub fn tag(&self, rng: &mut Rng) -> String {
        match rng.pick(&self.tags) {
            Some(tag) if rng.percent(70) => tag.clone(),
            _ => rng.one(["*", "\"1\"", "\"\"", "W/\"1\"", "1", "\"1\", \"2\"", ","]).to_owned(),
        }
    }
}

impl Owner {
    /// A segment of a path by its name in the contract, now and then one that names nothing.
    pub fn segment(&self, name: &str, rng: &mut Rng) -> String {
        if rng.percent(2) {
            return rng
                .one([
                    "0",
                    "1",
                    "-1",
                    "4294967296",
                    "18446744073709551616",
                    "x",
                    "%00",
                    "%ff",
                    "..",
                    "%2F",
                    "0190b0de",
                    "1.0",
                    "%F0%9F%98%80",
                ])
                .to_owned();
        }
        match name {
            "job_id" => self.job.clone(),
            "number" => self.number.to_string(),
            "fit_id" => self.fit.clone(),
            "record_id" => self.record.clone(),
            "stream_id" => self.stream.clone(),
            "key_id" => self.key.clone(),
            // one that is there would be another with every request
            "tenant" => rng.one(["default", "plant-7", "nobody"]).to_owned(),
            _ => "1".to_owned(),
        }
    }
}
