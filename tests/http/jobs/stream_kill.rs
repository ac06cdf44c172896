//! `kill -9` in the middle of a stream: every acknowledged block counts, once, and the estimate
//! continues as if nothing had happened.

use reqwest::Client;
use serde_json::json;

use super::{
    app::send,
    kill::Server,
    streams::{block, nodes, spec},
};
use crate::database;

const ROUNDS: u64 = 6;
const BLOCKS: u64 = 15;

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stream_goes_on_after_being_killed() {
    let directory = tempfile::tempdir().unwrap();
    let database = database::url(directory.path()).await;
    let (mut paths, mut job) = (Vec::new(), String::new());
    let mut answered = 0;
    for round in 0..=ROUNDS {
        let server = Server::start(&database);
        let client = Client::new();
        let url = |path: &str| format!("{}{path}", server.base);
        if paths.is_empty() {
            job = send(client.post(url("/v1/jobs")).json(&json!({"name": "w"})))
                .await
                .expect(201)
                .header("location")
                .unwrap()
                .to_owned();
            // the second one lives in one process only
            let opened = send(client.post(url(&format!("{job}/streams"))).json(&spec())).await.expect(201);
            paths.push(opened.header("location").unwrap().to_owned());
        }
        let path = format!("{}/nodes", paths[0]);
        let stored = send(client.get(url(&paths[0]))).await.expect(200).json()["sequence"].as_u64().unwrap();
        // the one that was under way when the server was killed may be stored or not
        assert!(stored == answered || stored == answered + 1, "{stored} stored, {answered} answered");
        if round == ROUNDS {
            finish(&client, &server, &job, &paths[0], stored).await;
            server.kill();
            break;
        }
        let of = |sequence: u64| block(sequence, 3 * sequence as usize..3 * sequence as usize + 3);
        for sequence in answered + 1..=answered + BLOCKS {
            let answer = send(client.post(url(&path)).json(&of(sequence))).await.expect(200).json();
            assert_eq!(answer["node_count"], 3 * sequence);
        }
        answered += BLOCKS;
        let under_way = tokio::spawn(client.post(url(&path)).json(&of(answered + 1)).send());
        tokio::task::yield_now().await;
        server.kill();
        if under_way.await.unwrap().is_ok_and(|response| response.status() == 200) {
            answered += 1;
        }
    }
}

async fn finish(client: &Client, server: &Server, job: &str, stream: &str, stored: u64) {
    let url = |path: &str| format!("{}{path}", server.base);
    let all = nodes(3..3 * stored as usize + 3);
    // a stream that was never interrupted, in other blocks
    let whole = send(client.post(url(&format!("{job}/streams"))).json(&spec())).await.expect(201);
    let whole = whole.header("location").unwrap().to_owned();
    let block = json!({"sequence": 1, "nodes": all});
    let whole = send(client.post(url(&format!("{whole}/nodes"))).json(&block)).await.expect(200).json();
    let here = send(client.get(url(stream))).await.expect(200).json();
    for (a, b) in whole["result"]["coefficients"]
        .as_array()
        .unwrap()
        .iter()
        .zip(here["result"]["coefficients"].as_array().unwrap())
    {
        let (a, b) = (a["least_squares"].as_f64().unwrap(), b["least_squares"].as_f64().unwrap());
        assert!((a - b).abs() <= 1e-12 * a.abs().max(1e-3), "{a} {b}");
    }
    let mut batch = spec();
    batch["nodes"] = all;
    let batch = send(client.post(url("/v1/fits")).json(&batch)).await.expect(200);
    let finished = send(client.post(url(&format!("{stream}/finish")))).await.expect(201);
    let (result, _) = batch.text.split_once(",\"spec\":").unwrap();
    assert!(finished.text.contains(result));
}
