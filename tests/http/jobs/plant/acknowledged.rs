//! Responses that clients received, compared with the stored state at the end.

use std::{
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

use tokio::time::sleep;

use super::clients::{PATIENCE, Plant, Written, nodes, sha256};
use crate::jobs::{
    app::send,
    streams::{block, spec},
};

/// Requests of each job that are sent once more.
const ASKED_AGAIN: usize = 100;

/// A job with the responses that its clients received.
#[derive(Default)]
pub struct Acknowledged {
    pub job: String,
    pub stream: String,
    pub iterations: Vec<Written>,
    pub blocks: Vec<[u8; 32]>,
    pub events: Arc<Mutex<Vec<u64>>>,
}

/// Everything acknowledged is stored once, and nothing else; its audit is complete.
pub async fn check_iterations(plant: &Plant, job: &str, acknowledged: &mut [Written]) {
    acknowledged.sort_unstable();
    let count = acknowledged.len() as u64;
    assert!(acknowledged.iter().map(|written| written.number).eq(1..=count), "each number was acknowledged once");
    let (mut there, mut cursor) = (Vec::new(), String::new());
    loop {
        let trace = format!("{}{job}/trace?limit=200{cursor}", plant.base);
        let page = send(plant.client.get(trace)).await.expect(200).json();
        let iterations = page["iterations"].as_array().unwrap();
        there.extend(iterations.iter().map(|iteration| iteration["id"].as_str().unwrap().to_owned()));
        let Some(next) = page["next_cursor"].as_str() else { break };
        cursor = format!("&cursor={next}");
    }
    assert!(there.iter().eq(acknowledged.iter().map(|written| &written.id)), "and is there once");
    let audit = plant.get(&format!("{}{}", plant.base, crate::jobs::audit::verify_of(job))).await.expect(200);
    assert_eq!(audit.json()["intact"], true, "{}", audit.text);
}

impl Acknowledged {
    pub async fn check(mut self, plant: &Plant) {
        check_iterations(plant, &self.job, &mut self.iterations).await;
        for written in self.iterations.iter().step_by(self.iterations.len() / ASKED_AGAIN + 1) {
            let again = plant.post_iteration(&self.job, &written.key).await.expect(201);
            assert_eq!(again.header("idempotency-replayed"), Some("true"));
            assert!(sha256(&again.text) == written.sha256, "iteration {} is answered as it was", written.number);
        }
        self.check_events(plant).await;
        self.check_blocks(plant).await;
    }

    async fn check_events(&self, plant: &Plant) {
        // the opening of the stream is an event, too
        let last = self.iterations.len() as u64 + 1 + self.blocks.len() as u64;
        let mut changed = (Instant::now(), 0);
        loop {
            let seen = self.events.lock().unwrap().last().copied().unwrap_or_default();
            if seen >= last {
                break;
            }
            if seen != changed.1 {
                changed = (Instant::now(), seen);
            }
            assert!(changed.0.elapsed() < PATIENCE, "{seen} of {last} events of {} are heard", self.job);
            sleep(Duration::from_millis(20)).await;
        }
        assert!(self.events.lock().unwrap().iter().copied().eq(1..=last), "each event arrived once and in its turn");
        let stored = send(plant.client.get(format!("{}{}", plant.base, self.stream))).await.expect(200).json();
        assert_eq!(stored["sequence"].as_u64(), Some(self.blocks.len() as u64));
    }

    /// The responses are those of an undisturbed stream.
    async fn check_blocks(&self, plant: &Plant) {
        let calm = plant.post(&format!("{}/streams", self.job), &spec()).await.expect(201);
        let calm = format!("{}/nodes", calm.header("location").unwrap());
        for (sequence, digest) in (1..).zip(&self.blocks) {
            let answer = plant.post(&calm, &nodes(sequence)).await.expect(200);
            assert!(sha256(&answer.text) == *digest, "block {sequence}: {}", answer.text);
        }
        let beyond = self.blocks.len() as u64 + 2;
        plant.post(&calm, &block(beyond, 0..5)).await.problem(409, "conflict");
    }
}
