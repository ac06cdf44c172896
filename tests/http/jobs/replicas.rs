//! Several servers on one store, each with a memory of its own: whichever gets the next request,
//! the responses are those of one server.

use std::sync::mpsc;

use reqwest::Method;
use serde_json::json;
use tokio::{sync::oneshot, task::JoinSet};

use super::{
    app::{Answer, TestApp, iteration, send},
    several::Replicas,
    streams::{block, spec},
};

/// A test of each case with two servers on each store.
macro_rules! on_each_store {
    ($($case:ident),+ $(,)?) => {
        $(mod $case {
            use super::Replicas;

            #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
            async fn sqlite() {
                super::$case(Replicas::on_sqlite(2).await).await;
            }

            #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
            #[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
            async fn postgres() {
                super::$case(Replicas::on_postgres(2).await).await;
            }
        })+
    };
}

on_each_store! {
    blocks_may_come_to_any_replica,
    of_two_blocks_of_one_number_one_counts_wherever_they_come,
    one_of_two_replicas_stores_under_a_key,
    under_one_key_and_one_version_one_change_is_made,
    numbers_have_no_gap_wherever_iterations_come,
}

/// Without what names the moment.
fn without_times(answer: &Answer) -> serde_json::Value {
    let mut json = answer.json();
    for name in ["id", "job_id", "created_at", "updated_at"] {
        json.as_object_mut().unwrap().remove(name);
    }
    json
}

async fn blocks_may_come_to_any_replica(replicas: Replicas) {
    let alone = TestApp::start().await;
    let job = alone.job().await;
    let own = alone.post(&format!("{job}/streams"), &spec()).await.expect(201).header("location").unwrap().to_owned();
    let stream = replicas.stream().await;
    let nodes = format!("{stream}/nodes");
    // each replica has an estimate of its own before the other goes on
    let turns = [0, 1, 0, 0, 0, 1, 1, 0, 1];
    for (sequence, &replica) in (1..).zip(&turns) {
        let from = 40 * (sequence as usize - 1);
        let body = block(sequence, from..from + 40);
        let answer = replicas.post(replica, &nodes, &body).await.expect(200);
        let expected = alone.post(&format!("{own}/nodes"), &body).await.expect(200);
        assert_eq!(answer.text, expected.text, "block {sequence} at replica {replica}");
        assert_eq!(answer.header("etag"), expected.header("etag"));
        // sent again, to the other one, which knows nothing of it yet
        let again = replicas.post(1 - replica, &nodes, &body).await.expect(200);
        assert_eq!(again.text, answer.text);
        let seen: Vec<_> =
            [replicas.get(0, &stream).await, replicas.get(1, &stream).await].map(|a| a.expect(200)).into();
        assert_eq!(seen[0].text, seen[1].text);
        assert_eq!(seen[0].header("etag"), answer.header("etag"));
    }
    let own = alone.get(&own).await.expect(200);
    assert_eq!(without_times(&replicas.get(0, &stream).await), without_times(&own));

    // finished where the last block did not come, and refused everywhere
    replicas.post(0, &format!("{stream}/finish"), &json!({})).await.expect(201);
    for replica in [1, 0] {
        let late = replicas.post(replica, &nodes, &block(10, 0..40)).await;
        late.problem(409, "conflict");
        assert!(late.text.contains("has become iteration 1"), "{}", late.text);
        assert_eq!(replicas.get(replica, &stream).await.expect(200).json()["state"], "finished");
    }
}

async fn of_two_blocks_of_one_number_one_counts_wherever_they_come(replicas: Replicas) {
    let stream = replicas.stream().await;
    let nodes = format!("{stream}/nodes");
    let mut count = 0;
    for sequence in 1..=12 {
        let (one, other) = (block(sequence, 0..30), block(sequence, 30..50));
        let answers = tokio::join!(replicas.post(0, &nodes, &one), replicas.post(1, &nodes, &other));
        let answers = [answers.0, answers.1];
        let (taken, refused): (Vec<_>, Vec<_>) = answers.iter().partition(|answer| answer.status == 200);
        assert_eq!((taken.len(), refused.len()), (1, 1), "{answers:?}");
        count = taken[0].json()["node_count"].as_u64().unwrap();
        let message = format!("Block {sequence} was posted before with other nodes");
        assert!(refused[0].text.contains(&message), "{}", refused[0].text);
    }
    for replica in [0, 1] {
        let seen = replicas.get(replica, &stream).await.expect(200).json();
        assert_eq!((seen["sequence"].as_u64(), seen["node_count"].as_u64()), (Some(12), Some(count)));
    }
}

/// A key whose first request runs at another replica: both compute, one stores, and the other gives
/// that answer, or says that the key was used for another request.
async fn one_of_two_replicas_stores_under_a_key(replicas: Replicas) {
    let path = format!("{}/iterations", replicas.job().await);
    // of a kind that is always left to the workers
    let mut one = iteration();
    one["estimator"] = json!({"type": "rank"});
    let mut another = one.clone();
    another["note"] = json!("another request");
    for (key, body) in [("same", one.clone()), ("other", another)] {
        // the second replica has looked for the key and waits for a worker
        let second = &replicas.states[1];
        let mut gates = Vec::new();
        for _ in 0..2 {
            let (open, gate) = mpsc::channel::<()>();
            let (begun, busy) = oneshot::channel();
            let state = second.clone();
            tokio::spawn(async move {
                let held = move || {
                    let _ = begun.send(());
                    let _ = gate.recv();
                };
                state.pool.run(held).await
            });
            busy.await.unwrap();
            gates.push(open);
        }
        let late = tokio::spawn(send(replicas.keyed(1, &path, key, &body)));
        while second.pool.waiting() == 0 {
            tokio::task::yield_now().await;
        }
        let first = send(replicas.keyed(0, &path, key, &one)).await.expect(201);
        drop(gates);
        let late = late.await.unwrap();
        if key == "same" {
            let late = late.expect(201);
            assert_eq!((late.header("idempotency-replayed"), &late.text), (Some("true"), &first.text));
            assert_eq!(late.header("etag"), first.header("etag"));
        } else {
            late.problem(422, "idempotency_key_reused");
        }
    }
    let trace = replicas.get(0, &path.replace("iterations", "trace")).await.json();
    assert_eq!(trace["iterations"].as_array().unwrap().len(), 2);
}

/// The same request at both replicas at once: one answer, byte for byte. Two changes of one
/// version: one is made.
async fn under_one_key_and_one_version_one_change_is_made(replicas: Replicas) {
    let job = replicas.job().await;
    let path = format!("{job}/iterations");
    for number in 1..=8 {
        let key = number.to_string();
        let ask = |replica| send(replicas.keyed(replica, &path, &key, &iteration()));
        let (one, two) = tokio::join!(ask(0), ask(1));
        let (one, two) = (one.expect(201), two.expect(201));
        assert_eq!(one.text, two.text);
        assert_eq!((one.json()["number"].as_u64(), one.header("etag")), (Some(number), two.header("etag")));

        let tag = replicas.get(number as usize % 2, &job).await.expect(200).header("etag").unwrap().to_owned();
        let patch = |replica| {
            let request = replicas.request(replica, Method::PATCH, &job).header("If-Match", &tag);
            send(request.json(&json!({"name": format!("{number} by {replica}")})))
        };
        let (one, two) = tokio::join!(patch(0), patch(1));
        let mut statuses = [one.status.as_u16(), two.status.as_u16()];
        statuses.sort_unstable();
        assert_eq!(statuses, [200, 412]);
        let changed = if one.status == 200 { one } else { two };
        for replica in [0, 1] {
            assert_eq!(replicas.get(replica, &job).await.header("etag"), changed.header("etag"));
        }
    }
}

async fn numbers_have_no_gap_wherever_iterations_come(replicas: Replicas) {
    let job = replicas.job().await;
    let mut asked = JoinSet::new();
    for count in 0..60 {
        asked.spawn(send(replicas.keyed(count % 2, &format!("{job}/iterations"), &count.to_string(), &iteration())));
    }
    let answers = asked.join_all().await;
    let mut numbers: Vec<u64> =
        answers.into_iter().map(|answer| answer.expect(201).json()["number"].as_u64().unwrap()).collect();
    numbers.sort_unstable();
    assert!(numbers.into_iter().eq(1..=60));
    // what was acknowledged is seen everywhere
    for replica in [0, 1] {
        let trace = replicas.get(replica, &format!("{job}/trace?limit=200")).await.expect(200).json();
        assert_eq!(trace["iterations"].as_array().unwrap().len(), 60);
    }
}
