//! A tenant with many requests next to one with few.

use std::sync::{
    Arc,
    atomic::{AtomicBool, AtomicUsize, Ordering},
};

use flankfit::{config::Authentication, jobs::Role};
use serde_json::json;

use super::keys::key_of;
use crate::harness::{Answer, TestApp, send};

/// Fits for the pool, long compared with the delay of a busy machine: some 50 ms for a `p` of 1.5,
/// and some 200 ms for 1.1.
fn work(p: f64) -> String {
    let x: Vec<f64> = (0..20_000).map(|k| f64::from(k) / 100.0).collect();
    let y: Vec<f64> = x.iter().map(|x| (x * 0.37).sin() + 0.01 * x).collect();
    json!({
        "nodes": {"type": "curve", "x": x, "y": y}, "model": {"type": "polynomial", "degree": 9},
        "estimator": {"type": "lp", "p": p}
    })
    .to_string()
}

async fn start(queue: usize) -> (TestApp, String, String) {
    let app = TestApp::start_with(|settings| {
        settings.auth = Authentication::Required;
        (settings.workers, settings.queue) = (1, queue);
    })
    .await;
    let noisy = key_of(&app, "default", Role::Reader).await;
    let root = key_of(&app, "", Role::Root).await;
    let made = send(app.post("/v1/tenants", r#"{"name":"quiet"}"#).bearer_auth(&root)).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let quiet = key_of(&app, "quiet", Role::Reader).await;
    (app, noisy, quiet)
}

fn ask(app: &TestApp, key: &str, text: &str) -> impl Future<Output = Answer> + Send + use<> {
    send(app.post("/v1/fits", text.to_owned()).bearer_auth(key))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_quiet_tenant_has_its_turn_in_a_full_queue() {
    let (app, noisy, quiet) = start(4).await;
    let text = work(1.1);
    let order = Arc::new(std::sync::Mutex::new(Vec::new()));
    let asked = |key: &str, name: &'static str| {
        let (asking, order) = (ask(&app, key, &text), order.clone());
        tokio::spawn(async move {
            let answer = asking.await;
            order.lock().unwrap().push((name, answer.status.as_u16()));
            answer
        })
    };
    let worker = app.occupy_worker().await;
    let mut all = Vec::new();
    for waiting in 1..=4 {
        all.push(asked(&noisy, "noisy"));
        app.until_waiting(waiting).await;
    }
    // alone it has the whole queue, and no more
    ask(&app, &noisy, &text).await.problem(503, "overloaded");
    let quiet = asked(&quiet, "quiet");
    app.until_waiting(5).await;
    let refused = ask(&app, &noisy, &text).await;
    refused.problem(503, "overloaded");
    assert_eq!(refused.header("retry-after"), "1");
    drop(worker);
    assert_eq!(quiet.await.unwrap().status, 200);
    for one in all {
        assert_eq!(one.await.unwrap().status, 200);
    }
    let order = order.lock().unwrap().clone();
    // one of the other's before it, whichever answer is read first
    let place = order.iter().position(|(name, _)| *name == "quiet").unwrap();
    assert!(place <= 1, "{order:?}");
    let metrics = send(app.get("/metrics")).await.text;
    assert!(metrics.contains("flankfit_shed_total{reason=\"queue\"}"), "{metrics}");
    app.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_flood_of_one_tenant_does_not_drown_another() {
    const CLIENTS: usize = 24;
    let (app, noisy, quiet) = start(16).await;
    let text = work(1.5);
    let (done, refused, ends): (Arc<AtomicUsize>, Arc<AtomicUsize>, Arc<AtomicBool>) = Default::default();
    let mut clients = Vec::new();
    for _ in 0..CLIENTS {
        let (client, url) = (app.client.clone(), app.url("/v1/fits"));
        let (noisy, text, ends) = (noisy.clone(), text.clone(), ends.clone());
        let (done, refused) = (done.clone(), refused.clone());
        clients.push(tokio::spawn(async move {
            while !ends.load(Ordering::Relaxed) {
                let request = client.post(&url).header("content-type", "application/json").bearer_auth(&noisy);
                let answer = send(request.body(text.clone())).await;
                match answer.status.as_u16() {
                    200 => done.fetch_add(1, Ordering::Relaxed),
                    503 => refused.fetch_add(1, Ordering::Relaxed),
                    other => panic!("{other}: {}", answer.text),
                };
            }
        }));
    }
    app.until_waiting(12).await;
    let mut before = Vec::new();
    for _ in 0..20 {
        let begun = done.load(Ordering::Relaxed);
        let answer = ask(&app, &quiet, &text).await;
        assert_eq!(answer.status, 200, "{}", answer.text);
        before.push(done.load(Ordering::Relaxed) - begun);
    }
    ends.store(true, Ordering::Relaxed);
    for client in clients {
        client.await.unwrap();
    }
    // the one at work and perhaps one more, and what ends while the answer is on its way: some,
    // on a busy machine; in the order of coming it would be the whole queue
    before.sort_unstable();
    assert!(before[before.len() / 2] <= 6, "{before:?}");
    assert!(refused.load(Ordering::Relaxed) > 0, "the queue was full");
    app.stop().await;
}
