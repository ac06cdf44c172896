//! A plant: three servers on one PostgreSQL behind haproxy, whose clients ask again whatever
//! happens. Servers are killed one after the other, PostgreSQL is restarted or killed, and
//! connections between them are cut around commits; what was acknowledged is there once, numbers
//! have no gap, streams and events go on as if nothing had been.
//!
//! `FLANKFIT_PLANT_SECONDS` says for how long.

mod acknowledged;
mod clients;
mod cuts;

use std::{
    env,
    net::SocketAddr,
    sync::{
        Arc, Mutex,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use serde_json::json;
use tokio::{
    task::{JoinSet, spawn_blocking},
    time::sleep,
};

use self::{
    acknowledged::{Acknowledged, check_iterations},
    clients::{PATIENCE, Plant},
    cuts::{CUTS, Cuts},
};
use super::{kill, streams::spec};
use crate::{
    plant::proxy::{Proxy, REPLICAS},
    postgres::{Server, shell},
};

/// Each with a stream and a listener.
const JOBS: usize = 8;
/// Writers of each job: 64 in all.
const WRITERS: usize = 8;
/// A server is killed as often; after every second one something happens to PostgreSQL.
const BETWEEN_KILLS: Duration = Duration::from_secs(2);
const BETWEEN_CUTS: Duration = Duration::from_millis(400);
/// Every kind of interruption comes once, where servers start in time.
const SECONDS: u64 = 14;
/// Interruptions of PostgreSQL, one after the other.
const INTERRUPTIONS: [&str; 3] = [
    "$BIN/pg_ctl -D data -l log -m fast -w restart",
    "$BIN/pg_ctl -D data -l log -m immediate -w restart",
    "kill -9 $(head -1 data/postmaster.pid); until $BIN/pg_ctl -D data -l log -w start 2>/dev/null; do sleep 0.1; done",
];

/// State of the interruptions, and their number.
struct Interrupted<'a> {
    plant: &'a Plant,
    server: &'a Server,
    cuts: &'a Cuts,
    url: &'a str,
    addresses: [SocketAddr; REPLICAS],
    replicas: Vec<kill::Server>,
    kills: u64,
    interruptions: [u64; INTERRUPTIONS.len()],
}

impl Interrupted<'_> {
    /// Kills servers and what they store in for that time, and on a busy machine until everything
    /// has come at least once.
    async fn run(&mut self, time: Duration) {
        let begun = Instant::now();
        for round in 0.. {
            sleep((BETWEEN_KILLS * (round as u32 + 1)).saturating_sub(begun.elapsed())).await;
            if begun.elapsed() >= time && self.is_whole() || begun.elapsed() >= time + PATIENCE {
                break;
            }
            self.replicas.remove(0).kill();
            self.kills += 1;
            let (url, address) = (self.url.to_owned(), self.addresses[round % REPLICAS]);
            let started = spawn_blocking(move || kill::Server::start_at(address, &url, &[]));
            self.replicas.push(started.await.unwrap());
            if round % 2 == 1 {
                let which = round / 2 % INTERRUPTIONS.len();
                let mut command = shell(&self.server.folder, INTERRUPTIONS[which]);
                let done = spawn_blocking(move || command.status()).await.unwrap().unwrap();
                assert!(done.success());
                self.interruptions[which] += 1;
            }
        }
        self.plant.over.store(true, Ordering::SeqCst);
    }

    /// True if there was everything that a run is to survive.
    fn is_whole(&self) -> bool {
        let cuts = self.cuts.fallen();
        self.interruptions.iter().chain(&cuts).all(|count| *count > 0)
    }

    /// Fails unless there was something to survive.
    fn assert_whole(&self, time: Duration) {
        // a busy machine takes its time to start a server: a quarter of what the clock allows
        let least = time.as_secs() / (4 * BETWEEN_KILLS.as_secs());
        assert!(self.kills >= least.max(1), "{} servers were killed in {time:?}", self.kills);
        assert!(self.is_whole(), "something is missing of what is printed above");
        let broken = self.plant.counts.broken.load(Ordering::Relaxed);
        let refused = self.plant.counts.refused.load(Ordering::Relaxed);
        assert!(broken + refused > 0, "no client has met with any of it");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(any(without_postgres, without_haproxy), ignore = "there is no PostgreSQL server, or no haproxy")]
async fn nothing_is_lost_or_repeated_whatever_is_killed() {
    let seconds = env::var("FLANKFIT_PLANT_SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(SECONDS);
    let server = Server::start();
    let (name, cuts) = (server.with_schema().await, Arc::<Cuts>::default());
    let port = cuts::open(server.folder.join(".s.PGSQL.5432"), cuts.clone()).await;
    let url = format!("postgres://owner@127.0.0.1:{port}/{name}?sslmode=disable");
    let proxy = Proxy::start(3);
    let replicas = proxy.servers.map(|address| kill::Server::start_at(address, &url, &[])).into();
    let plant = Arc::new(Plant::new(&proxy.base));
    let mut acknowledged = Vec::new();
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
        probes.spawn(async move { (of, at.0.stream(&at.1, of % 2 == 0).await) });
        acknowledged.push(Acknowledged { job, stream, events, ..Acknowledged::default() });
    }
    let watched = plant.post("/v1/jobs", &json!({"name": "wheel"})).await.expect(201);
    let watched = watched.header("location").unwrap().to_owned();
    let watching = tokio::spawn({
        let at = (plant.clone(), watched.clone());
        async move { at.0.write_watched(&at.1).await }
    });
    let cutting = tokio::spawn({
        let cuts = cuts.clone();
        async move {
            for cut in CUTS.into_iter().cycle() {
                sleep(BETWEEN_CUTS).await;
                // each has its turn: without PostgreSQL nothing commits
                while cuts.is_armed() {
                    sleep(BETWEEN_CUTS).await;
                }
                cuts.arm(cut);
            }
        }
    });
    let (addresses, kills, interruptions) = (proxy.servers, 0, Default::default());
    let mut interrupted = Interrupted {
        plant: &plant,
        server: &server,
        cuts: &cuts,
        url: &url,
        addresses,
        replicas,
        kills,
        interruptions,
    };
    let time = Duration::from_secs(seconds);
    interrupted.run(time).await;
    cutting.abort();

    for (of, stored) in writers.join_all().await {
        acknowledged[of].iterations.extend(stored);
    }
    for (of, answers) in probes.join_all().await {
        acknowledged[of].blocks = answers;
    }
    let mut made = watching.await.unwrap();
    report(&interrupted, &acknowledged);
    println!("{} iterations were stored with progress", made.len());
    interrupted.assert_whole(time);
    let failures = std::mem::take(&mut *plant.failures.lock().unwrap());
    assert!(failures.is_empty(), "{} failures: {:#?}", failures.len(), &failures[..failures.len().min(5)]);
    let mut checks = JoinSet::new();
    for one in acknowledged {
        let plant = plant.clone();
        checks.spawn(async move { one.check(&plant).await });
    }
    checks.join_all().await;
    assert!(!made.is_empty());
    check_iterations(&plant, &watched, &mut made).await;
    println!("nothing of it is lost, nothing is there twice");
    interrupted.replicas.into_iter().for_each(kill::Server::kill);
}

/// Prints what happened.
fn report(interrupted: &Interrupted<'_>, acknowledged: &[Acknowledged]) {
    let counts = &interrupted.plant.counts;
    let count = |count: &AtomicU64| count.load(Ordering::Relaxed);
    println!(
        "{} requests; asked again after {} broken connections and {} refusals, {} of them outcome_unknown",
        count(&counts.requests),
        count(&counts.broken),
        count(&counts.refused),
        count(&counts.unknown),
    );
    let [fast, immediate, killed] = interrupted.interruptions;
    println!(
        "{} servers killed; PostgreSQL restarted {fast} times, {immediate} times at once, killed {killed} times",
        interrupted.kills
    );
    let [before, with, after] = interrupted.cuts.fallen();
    println!("connections cut before COMMIT {before}, with it {with}, before its answer {after}");
    let iterations: usize = acknowledged.iter().map(|one| one.iterations.len()).sum();
    let blocks: usize = acknowledged.iter().map(|one| one.blocks.len()).sum();
    println!("acknowledged: {iterations} iterations, {blocks} blocks");
}
