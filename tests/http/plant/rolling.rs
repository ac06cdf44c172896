//! A rolling restart: one server after the other gets the signal to end and is started anew, while
//! clients work through a proxy that asks nobody twice. No request fails.
//!
//! `FLANKFIT_ROLLING_ROUNDS` says how often.

use std::{
    collections::BTreeMap,
    env,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use reqwest::Client;
use serde_json::{Value, json};
use tokio::{task::JoinSet, time::sleep};

use super::proxy::{Proxy, REPLICAS};
use crate::{
    jobs::{
        app::{iteration, send},
        kill,
        streams::{block, spec},
    },
    postgres::Server,
};

/// Longer than the proxy takes to see that a server ends.
const DRAINING: [&str; 2] = ["--drain-delay", "3"];
const PATIENCE: Duration = Duration::from_secs(60);
/// Clients of each kind.
const CLIENTS: usize = 4;

/// End of the load, and the number of requests of all clients.
#[derive(Clone, Default)]
struct Load {
    over: Arc<AtomicBool>,
    asked: Arc<AtomicU64>,
}

/// Posts again and again until it is over: how many requests there were, and the failures.
async fn client(base: String, at: Load, request: impl Fn(u64) -> (String, Value)) -> (u64, Vec<String>) {
    // what failed is not sent again unseen
    let client = Client::builder().no_proxy().retry(reqwest::retry::never()).build().unwrap();
    let (mut asked, mut failures) = (0, Vec::new());
    while !at.over.load(Ordering::SeqCst) {
        asked += 1;
        at.asked.fetch_add(1, Ordering::SeqCst);
        let (path, body) = request(asked);
        match client.post(format!("{base}{path}")).json(&body).send().await {
            Ok(answer) if answer.status().is_success() => {
                let status = answer.status();
                if let Err(error) = answer.bytes().await {
                    failures.push(format!("{path}: {status}, then {error:?}"));
                }
            }
            Ok(answer) => failures.push(format!("{path}: {} {:?}", answer.status(), answer.text().await)),
            Err(error) => failures.push(format!("{path}: {error:?}")),
        }
    }
    (asked, failures)
}

/// A new server where one has ended by itself, ready for requests.
async fn renewed(mut old: kill::Server, address: std::net::SocketAddr, url: &str) -> kill::Server {
    old.terminate();
    let begun = Instant::now();
    let ended = loop {
        if let Some(ended) = old.ended() {
            break ended;
        }
        assert!(begun.elapsed() < PATIENCE, "the server does not end");
        sleep(Duration::from_millis(20)).await;
    };
    assert!(ended.success(), "{ended}");
    assert!(begun.elapsed() >= Duration::from_secs(3), "it goes on for a while");
    let url = url.to_owned();
    let start = move || kill::Server::start_at(address, &url, &DRAINING);
    let new = tokio::task::spawn_blocking(start).await.unwrap();
    until_ready(&new.base).await;
    new
}

pub async fn until_ready(base: &str) {
    let begun = Instant::now();
    let ready = async || reqwest::get(format!("{base}/readyz")).await.is_ok_and(|answer| answer.status() == 200);
    while !ready().await {
        assert!(begun.elapsed() < PATIENCE, "{base} is not ready");
        sleep(Duration::from_millis(20)).await;
    }
}

/// Number of successful responses of a server, by the kind of its clients.
async fn answered(base: &str) -> BTreeMap<&'static str, u64> {
    let metrics = reqwest::get(format!("{base}/metrics")).await.unwrap().text().await.unwrap();
    let kinds = ["/v1/fits", "/v1/jobs/{job_id}/iterations", "/v1/streams/{stream_id}/nodes"];
    let count = |path: &str| {
        let of = |line: &&str| line.starts_with("flankfit_http_requests_total{") && line.contains("status=\"20");
        let lines = metrics.lines().filter(of).filter(|line| line.contains(&format!("path=\"{path}\"")));
        lines.map(|line| line.rsplit(' ').next().unwrap().parse::<u64>().unwrap()).sum()
    };
    kinds.into_iter().map(|path| (path, count(path))).collect()
}

/// True if clients of both kinds that come to any server have come to this one.
fn is_used(answered: &BTreeMap<&'static str, u64>) -> bool {
    answered["/v1/fits"] > 0 && answered["/v1/jobs/{job_id}/iterations"] > 0
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(any(without_postgres, without_haproxy), ignore = "there is no PostgreSQL server, or no haproxy")]
async fn no_request_fails_while_one_server_after_the_other_is_renewed() {
    let rounds: usize = env::var("FLANKFIT_ROLLING_ROUNDS").ok().and_then(|text| text.parse().ok()).unwrap_or(1);
    let server = Server::start();
    let url = server.database().await;
    let proxy = Proxy::start(0);
    let mut replicas: Vec<_> =
        proxy.servers.iter().map(|address| kill::Server::start_at(*address, &url, &DRAINING)).collect();
    until_ready(&proxy.base).await;

    let load = Load::default();
    let mut clients = JoinSet::new();
    let posted = async |path: &str, body: &Value| {
        let made = send(Client::new().post(format!("{}{path}", proxy.base)).json(body)).await.expect(201);
        made.header("location").unwrap().to_owned()
    };
    for _ in 0..CLIENTS {
        let job = posted("/v1/jobs", &json!({"name": "wheel"})).await;
        let stream = posted(&format!("{job}/streams"), &spec()).await;
        let at = || (proxy.base.clone(), load.clone());
        let (base, end) = at();
        clients.spawn(client(base, end, move |_| (format!("{job}/iterations"), iteration())));
        let (base, end) = at();
        let fit: Value = serde_json::from_str(crate::harness::CURVE).unwrap();
        clients.spawn(client(base, end, move |_| ("/v1/fits".to_owned(), fit.clone())));
        let (base, end) = at();
        let nodes = move |number: u64| {
            let from = 5 * number as usize;
            (format!("{stream}/nodes"), block(number, from..from + 5))
        };
        clients.spawn(client(base, end, nodes));
    }
    for round in 0..rounds * REPLICAS {
        sleep(Duration::from_millis(500)).await;
        let old = replicas.remove(0);
        replicas.push(renewed(old, proxy.servers[round % REPLICAS], &url).await);
    }
    sleep(Duration::from_secs(1)).await;
    // a busy machine takes its time to send the last one its share, and for so many requests
    let begun = Instant::now();
    for replica in &replicas {
        while !is_used(&answered(&replica.base).await) && begun.elapsed() < PATIENCE {
            sleep(Duration::from_millis(100)).await;
        }
    }
    while load.asked.load(Ordering::SeqCst) <= 600 && begun.elapsed() < 2 * PATIENCE {
        sleep(Duration::from_millis(100)).await;
    }
    load.over.store(true, Ordering::SeqCst);

    let (mut asked, mut failures) = (0, Vec::new());
    for (requests, failed) in clients.join_all().await {
        asked += requests;
        failures.extend(failed);
    }
    println!("{asked} requests, {} failures", failures.len());
    let first: Vec<_> = failures.iter().take(5).collect();
    assert!(failures.is_empty(), "{} of {asked}: {first:#?}\n{}", failures.len(), proxy.log());
    assert!(asked > 500, "only {asked} requests");
    for replica in &replicas {
        let answered = answered(&replica.base).await;
        assert!(is_used(&answered), "{answered:?}");
    }
    replicas.into_iter().for_each(kill::Server::kill);
}
