//! Server-sent events of a job: everything once, in order, and on from where a client was.

use std::time::Duration;

use reqwest::{Method, RequestBuilder, Response};
use serde_json::{Value, json};

use super::{
    app::{TestApp, iteration, send},
    streams::{block, spec},
};

/// An event stream, read event by event.
pub struct Listener {
    response: Response,
    text: String,
}

/// Id, name and data.
pub type Event = (u64, String, Value);

impl Listener {
    async fn open(app: &TestApp, path: &str, last: Option<&str>) -> Self {
        Self::of(app.request(Method::GET, path), last).await.expect("a listener")
    }

    /// Opens the events; `None` if nobody responds, or the store does not.
    pub async fn of(request: RequestBuilder, last: Option<&str>) -> Option<Self> {
        let mut request = request.header("accept-encoding", "gzip, zstd");
        if let Some(last) = last {
            request = request.header("Last-Event-ID", last);
        }
        let response = request.send().await.ok().filter(|response| response.status() == 200)?;
        assert_eq!(response.headers()["content-type"], "text/event-stream");
        assert!(!response.headers().contains_key("content-encoding"));
        Some(Listener { response, text: String::new() })
    }

    /// The next event; `None` at the end.
    pub async fn next(&mut self) -> Option<Event> {
        let (id, name, data) = self.entry().await?;
        assert_eq!(data["number"].to_string(), id);
        Some((id.parse().unwrap(), name, data))
    }

    /// The same with the id as sent.
    pub async fn entry(&mut self) -> Option<(String, String, Value)> {
        loop {
            if let Some((entry, rest)) = self.text.split_once("\n\n") {
                let (entry, rest) = (entry.to_owned(), rest.to_owned());
                self.text = rest;
                let field = |name: &str| entry.lines().find_map(|l| l.strip_prefix(name)).map(str::to_owned);
                if let (Some(id), Some(name), Some(data)) = (field("id: "), field("event: "), field("data: ")) {
                    let data: Value = serde_json::from_str(&data).unwrap();
                    assert_eq!(data["type"].as_str(), Some(name.as_str()));
                    return Some((id, name, data));
                }
                continue;
            }
            let chunk = tokio::time::timeout(Duration::from_secs(30), self.response.chunk()).await.expect("an event");
            let chunk = chunk.ok().flatten()?;
            self.text.push_str(std::str::from_utf8(&chunk).unwrap());
        }
    }

    async fn some(&mut self, count: usize) -> Vec<Event> {
        let mut events = Vec::new();
        while events.len() < count {
            events.push(self.next().await.expect("an event"));
        }
        events
    }
}

fn names(events: &[Event]) -> Vec<&str> {
    events.iter().map(|(_, name, _)| name.as_str()).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_event_arrives_once_and_in_order() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let path = format!("{job}/events");
    let mut listener = Listener::open(&app, &path, None).await;
    let place = app.iteration(&job).await;
    let refit = app
        .post(&format!("{place}/fits"), &json!({"model": {"type": "polynomial", "degree": 1}}))
        .await
        .expect(201)
        .json();
    app.put(&format!("{place}/chosen-fit"), &json!({"fit_id": refit["id"], "reason": "simpler"})).await.expect(200);
    app.patch(&place, &json!({"decision": "accepted"})).await.expect(200);
    // said before: nothing happened
    app.patch(&place, &json!({"decision": "accepted"})).await.expect(200);
    let stream = app.stream(&job, &spec()).await;
    app.post(&format!("{stream}/nodes"), &block(1, 0..20)).await.expect(200);
    app.post(&format!("{stream}/nodes"), &block(1, 0..20)).await.expect(200);
    send(app.request(Method::POST, &format!("{stream}/finish"))).await.expect(201);
    app.delete(&stream).await.expect(204);

    let events = listener.some(9).await;
    let kinds = ["iteration", "fit", "fit", "decision", "stream", "stream", "iteration", "stream", "stream"];
    assert_eq!(names(&events), kinds);
    assert!(events.iter().map(|(id, ..)| *id).eq(1..=9));
    let data = |i: usize| &events[i].2;
    assert_eq!((data(0)["iteration_number"].as_u64(), data(0)["fit_id"].is_string()), (Some(1), true));
    assert_eq!((&data(1)["fit_id"], &data(1)["chosen"]), (&refit["id"], &json!(false)));
    assert_eq!(
        (&data(2)["fit_id"], &data(2)["chosen"], &data(2)["reason"]),
        (&refit["id"], &json!(true), &json!("simpler"))
    );
    assert_eq!(data(3)["decision"], "accepted");
    let states: Vec<&str> = [4, 5, 7, 8].map(|i| data(i)["state"].as_str().unwrap()).to_vec();
    assert_eq!(states, ["open", "block", "finished", "deleted"]);
    assert_eq!((data(5)["sequence"].as_u64(), data(5)["node_count"].as_u64()), (Some(1), Some(20)));
    assert_eq!(data(7)["iteration_number"], 2);

    // on from anywhere, by header or by query, and after a restart
    app.restart().await;
    for last in 0..9 {
        let mut again = Listener::open(&app, &path, Some(&last.to_string())).await;
        assert_eq!(again.some(9 - last).await, events[last..]);
    }
    // an id of another database, as after a backup was restored: everything anew
    let mut foreign = Listener::open(&app, &path, Some("999")).await;
    assert_eq!(foreign.some(9).await, events);
    let mut again = Listener::open(&app, &format!("{path}?last_event_id=7"), None).await;
    assert_eq!(again.some(2).await, events[7..]);
    let mut latest = Listener::open(&app, &format!("{path}?last_event_id=latest"), None).await;
    app.iteration(&job).await;
    assert_eq!(latest.next().await.map(|(id, name, _)| (id, name)), Some((10, "iteration".to_owned())));

    app.get("/v1/jobs/00000000-0000-7000-8000-000000000000/events").await.problem(404, "not_found");
    let refused = app.get(&format!("{path}?last_event_id=first")).await.problem(422, "invalid_request");
    assert_eq!(refused, ["/last_event_id"]);
    // a shutdown ends what is open, and does not wait for it
    app.stop().await;
    assert_eq!(latest.next().await, None);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn nothing_is_lost_between_many_writers_and_a_client_that_comes_and_goes() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let path = format!("{job}/events");
    let mut writers = tokio::task::JoinSet::new();
    for _ in 0..4 {
        let (client, url) = (app.client.clone(), format!("{}{job}/iterations", app.base));
        writers.spawn(async move {
            for _ in 0..25 {
                send(client.post(&url).json(&iteration())).await.expect(201);
            }
        });
    }
    let mut ids = Vec::new();
    let mut last = None;
    while ids.len() < 100 {
        let mut listener = Listener::open(&app, &path, last.as_deref()).await;
        for (id, ..) in listener.some(7.min(100 - ids.len())).await {
            ids.push(id);
        }
        last = ids.last().map(u64::to_string);
    }
    assert!(ids.into_iter().eq(1..=100));
    writers.join_all().await;
    app.stop().await;
}
