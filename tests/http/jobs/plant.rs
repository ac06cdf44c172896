//! A plant: three servers on one PostgreSQL behind haproxy, whose clients ask again whatever
//! happens. Servers are killed one after the other and PostgreSQL is restarted or killed; what was
//! acknowledged is there once, numbers have no gap, streams and events go on as if nothing had
//! been.
//!
//! `FLANKFIT_PLANT_SECONDS` says for how long.

use std::{
    env,
    net::SocketAddr,
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use reqwest::{Client, Method, RequestBuilder};
use serde_json::{Value, json};
use tokio::{task::JoinSet, time::sleep};

use super::{
    app::{Answer, iteration, send},
    events::Listener,
    kill, long,
    streams::{block, spec},
};
use crate::{
    plant::proxy::{Proxy, REPLICAS},
    postgres::{Server, shell},
};

const JOBS: usize = 2;
const WRITERS: usize = 6;
const MOST_BLOCKS: usize = 5000;
/// For so long a client asks again.
const PATIENCE: Duration = Duration::from_secs(60);
/// What happens to PostgreSQL, one after the other.
const INTERRUPTIONS: [&str; 3] = [
    "$BIN/pg_ctl -D data -l log -m fast -w restart",
    "$BIN/pg_ctl -D data -l log -m immediate -w restart",
    "kill -9 $(head -1 data/postmaster.pid); until $BIN/pg_ctl -D data -l log -w start 2>/dev/null; do sleep 0.1; done",
];

/// The servers as their clients know them.
struct Plant {
    client: Client,
    base: String,
    over: AtomicBool,
}

impl Plant {
    fn is_over(&self) -> bool {
        self.over.load(Ordering::SeqCst)
    }

    /// Asks until somebody has answered, and not that it cannot.
    async fn ask(&self, path: &str, request: impl Fn(RequestBuilder) -> RequestBuilder) -> Answer {
        let begun = Instant::now();
        loop {
            let asked = self.client.request(Method::POST, format!("{}{path}", self.base));
            if let Some(answer) = answered(request(asked)).await {
                return answer;
            }
            assert!(begun.elapsed() < PATIENCE, "{path} is not answered");
            sleep(Duration::from_millis(20)).await;
        }
    }

    async fn post(&self, path: &str, body: &Value) -> Answer {
        self.ask(path, |request| request.json(body)).await
    }

    /// Stores iterations one after the other: their numbers and answers.
    async fn write(&self, writer: usize, job: &str) -> Vec<(u64, String)> {
        let mut stored = Vec::new();
        while !self.is_over() {
            let key = format!("{writer}-{}", stored.len());
            let body = iteration();
            let path = format!("{job}/iterations");
            let keyed = |request: RequestBuilder| request.header("Idempotency-Key", &key).json(&body);
            let answer = self.ask(&path, keyed).await;
            assert_eq!(answer.status, 201, "{}, {:#?}", answer.text, kill::ERRORS.lock().unwrap());
            stored.push((answer.json()["number"].as_u64().unwrap(), answer.text));
        }
        stored
    }

    /// Has iterations made by operations, one after the other: their numbers and answers, and how
    /// many of them were begun more than once. One whose servers were lost too often has stored
    /// nothing.
    async fn operate(&self, job: &str) -> (Vec<(u64, String)>, u64) {
        let (mut stored, mut again) = (Vec::new(), 0);
        let path = format!("{job}/iterations");
        for turn in 0.. {
            if self.is_over() {
                break;
            }
            let (key, body) = (format!("operation {turn}"), long::robust_iteration());
            let later = |request: RequestBuilder| {
                request.header("Idempotency-Key", &key).header("Prefer", "respond-async").json(&body)
            };
            let begun = self.ask(&path, later).await.expect(202);
            let place = format!("{}{}", self.base, begun.header("location").unwrap());
            let made = self.result(&place).await;
            if made.status == 500 {
                made.problem(500, "interrupted");
                continue;
            }
            stored.push((made.expect(201).json()["number"].as_u64().unwrap(), String::new()));
            let told = self.get(&place).await;
            again += u64::from(told.json()["attempts"].as_u64().unwrap() > 1);
            stored.last_mut().unwrap().1 = self.result(&place).await.expect(201).text;
        }
        (stored, again)
    }

    /// The answer of an operation, once it has one.
    async fn result(&self, place: &str) -> Answer {
        let begun = Instant::now();
        loop {
            let answer = self.get(&format!("{place}/result")).await;
            if answer.status != 409 {
                return answer;
            }
            assert!(begun.elapsed() < PATIENCE, "{place} does not end");
        }
    }

    /// Asks until somebody has answered.
    async fn get(&self, url: &str) -> Answer {
        let begun = Instant::now();
        loop {
            let asked = self.client.get(url).header("Prefer", "wait=1").send().await;
            if let Ok(response) = asked
                && !matches!(response.status().as_u16(), 502..=504)
            {
                let (status, headers) = (response.status(), response.headers().clone());
                if let Ok(text) = response.text().await {
                    return Answer { status, headers, text };
                }
            }
            assert!(begun.elapsed() < PATIENCE, "{url} is not answered");
            sleep(Duration::from_millis(20)).await;
        }
    }

    /// Posts the blocks of a stream: the answers.
    async fn stream(&self, stream: &str) -> Vec<String> {
        let mut answers = Vec::new();
        for sequence in (1..=MOST_BLOCKS).take_while(|_| !self.is_over()) {
            let path = format!("{stream}/nodes");
            answers.push(self.post(&path, &nodes(sequence)).await.expect(200).text);
            sleep(Duration::from_millis(10)).await;
        }
        answers
    }

    /// Listens to a job again and again: the numbers of its events in the order in which they came.
    async fn listen(&self, job: &str, seen: &Mutex<Vec<u64>>) {
        loop {
            let last = seen.lock().unwrap().last().map(u64::to_string);
            let request = self.client.request(Method::GET, format!("{}{job}/events", self.base));
            if let Some(mut listener) = Listener::of(request, last.as_deref()).await {
                while let Some((number, ..)) = listener.next().await {
                    seen.lock().unwrap().push(number);
                }
            }
            sleep(Duration::from_millis(20)).await;
        }
    }
}

/// A block of a stream.
fn nodes(sequence: usize) -> Value {
    block(sequence as u64, 5 * sequence..5 * sequence + 5)
}

/// An answer that is one: of a server that is there (the proxy says 502 where it has been lost),
/// whose store is there, and that does not work on the same request already.
async fn answered(request: RequestBuilder) -> Option<Answer> {
    let response = request.send().await.ok()?;
    let (status, headers) = (response.status(), response.headers().clone());
    let answer = Answer { status, headers, text: response.text().await.ok()? };
    let again =
        matches!(status.as_u16(), 502..=504) || status == 409 && answer.json()["code"] == "idempotency_key_in_use";
    (!again).then_some(answer)
}

/// Kills servers and what they store in, until it is enough; the servers that are left.
async fn interrupted(
    plant: &Plant,
    server: &Server,
    url: &str,
    addresses: [SocketAddr; REPLICAS],
    mut replicas: Vec<kill::Server>,
    time: Duration,
) -> Vec<kill::Server> {
    let begun = Instant::now();
    for round in 0.. {
        sleep(Duration::from_millis(700)).await;
        if begun.elapsed() >= time {
            break;
        }
        match round % 4 {
            3 => {
                let mut command = shell(&server.folder, INTERRUPTIONS[round / 4 % INTERRUPTIONS.len()]);
                let done = tokio::task::spawn_blocking(move || command.status()).await.unwrap().unwrap();
                assert!(done.success());
            }
            replica => {
                replicas.remove(0).kill();
                let (url, address) = (url.to_owned(), addresses[replica]);
                let begun = move || kill::Server::start_at(address, &url, &[]);
                replicas.push(tokio::task::spawn_blocking(begun).await.unwrap());
            }
        }
    }
    plant.over.store(true, Ordering::SeqCst);
    replicas
}

/// A job with what its clients were told.
#[derive(Default)]
struct Told {
    job: String,
    stream: String,
    iterations: Vec<(u64, String)>,
    blocks: Vec<String>,
    events: Arc<Mutex<Vec<u64>>>,
}

/// What was told is there once, and nothing else.
async fn check_iterations(plant: &Plant, job: &str, told: &mut [(u64, String)]) {
    told.sort_unstable();
    let count = told.len() as u64;
    assert!(told.iter().map(|(number, _)| *number).eq(1..=count), "each number was told once");
    let mut there = Vec::new();
    let mut cursor = String::new();
    loop {
        let trace = format!("{}{job}/trace?limit=200{cursor}", plant.base);
        let page = send(plant.client.get(trace)).await.expect(200).json();
        there.extend(page["iterations"].as_array().unwrap().iter().map(|iteration| iteration["id"].clone()));
        let Some(next) = page["next_cursor"].as_str() else { break };
        cursor = format!("&cursor={next}");
    }
    let ids = told.iter().map(|(_, text)| serde_json::from_str::<Value>(text).unwrap()["id"].clone());
    assert!(there.into_iter().eq(ids), "and is there once");
}

impl Told {
    async fn check(mut self, plant: &Plant) {
        check_iterations(plant, &self.job, &mut self.iterations).await;
        let count = self.iterations.len() as u64;
        // the opening of the stream is an event, too
        let last = count + 1 + self.blocks.len() as u64;
        let begun = Instant::now();
        while self.events.lock().unwrap().last().is_none_or(|seen| *seen < last) {
            assert!(begun.elapsed() < PATIENCE, "{last} events are not heard");
            sleep(Duration::from_millis(20)).await;
        }
        assert!(self.events.lock().unwrap().iter().copied().eq(1..=last), "each event was told once and in its turn");

        let stored = send(plant.client.get(format!("{}{}", plant.base, self.stream))).await.expect(200).json();
        assert_eq!(stored["sequence"].as_u64(), Some(self.blocks.len() as u64));
        // a stream that nothing happened to
        let calm = plant.post(&format!("{}/streams", self.job), &spec()).await.expect(201);
        let calm = format!("{}/nodes", calm.header("location").unwrap());
        for (sequence, told) in (1..).zip(&self.blocks) {
            assert_eq!(plant.post(&calm, &nodes(sequence)).await.expect(200).text, *told, "block {sequence}");
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(any(without_postgres, without_haproxy), ignore = "there is no PostgreSQL server, or no haproxy")]
async fn nothing_is_lost_or_repeated_whatever_is_killed() {
    let seconds = env::var("FLANKFIT_PLANT_SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(10);
    let server = Server::start();
    let url = server.database().await;
    let proxy = Proxy::start(3);
    let replicas = proxy.servers.map(|address| kill::Server::start_at(address, &url, &[])).into();
    let plant = Plant { client: Client::new(), base: proxy.base.clone(), over: AtomicBool::new(false) };
    let plant = Arc::new(plant);
    let mut told = Vec::new();
    let (mut listeners, mut writers, mut probes) = (JoinSet::new(), JoinSet::new(), JoinSet::new());
    for of in 0..JOBS {
        let job = plant.post("/v1/jobs", &json!({"name": "wheel"})).await.expect(201);
        let job = job.header("location").unwrap().to_owned();
        let stream = plant.post(&format!("{job}/streams"), &spec()).await.expect(201);
        let stream = stream.header("location").unwrap().to_owned();
        let events = Arc::<Mutex<Vec<u64>>>::default();
        let at = (plant.clone(), job.clone(), events.clone());
        listeners.spawn(async move { at.0.listen(&at.1, &at.2).await });
        for writer in 0..WRITERS {
            let at = (plant.clone(), job.clone());
            writers.spawn(async move { (of, at.0.write(writer, &at.1).await) });
        }
        let at = (plant.clone(), stream.clone());
        probes.spawn(async move { (of, at.0.stream(&at.1).await) });
        told.push(Told { job, stream, events, ..Told::default() });
    }
    let operated = plant.post("/v1/jobs", &json!({"name": "wheel"})).await.expect(201);
    let operated = operated.header("location").unwrap().to_owned();
    let operating = tokio::spawn({
        let at = (plant.clone(), operated.clone());
        async move { at.0.operate(&at.1).await }
    });
    let replicas = interrupted(&plant, &server, &url, proxy.servers, replicas, Duration::from_secs(seconds)).await;
    for (of, stored) in writers.join_all().await {
        told[of].iterations.extend(stored);
    }
    for (of, answers) in probes.join_all().await {
        told[of].blocks = answers;
    }
    let (mut made, again) = operating.await.unwrap();
    println!("{} operations, of which {again} were begun more than once", made.len());
    assert!(!made.is_empty());
    check_iterations(&plant, &operated, &mut made).await;
    for told in told {
        println!("{} iterations, {} blocks", told.iterations.len(), told.blocks.len());
        told.check(&plant).await;
    }
    replicas.into_iter().for_each(kill::Server::kill);
}
