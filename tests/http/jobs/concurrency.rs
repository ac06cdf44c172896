//! Many clients at once.

use std::collections::BTreeSet;

use reqwest::Method;
use serde_json::json;
use tokio::task::JoinSet;

use super::app::{TestApp, iteration, send};

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn thirty_two_clients_get_numbers_without_gaps() {
    const CLIENTS: usize = 32;
    const EACH: usize = 6;
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let path = format!("{job}/iterations");
    let mut clients = JoinSet::new();
    for _ in 0..CLIENTS {
        let client = app.client.clone();
        let url = format!("{}{path}", app.base);
        clients.spawn(async move {
            let mut numbers = Vec::new();
            for _ in 0..EACH {
                let answer = send(client.post(&url).json(&iteration())).await.expect(201);
                numbers.push(answer.json()["number"].as_u64().unwrap());
            }
            numbers
        });
    }
    let numbers: Vec<u64> = clients.join_all().await.into_iter().flatten().collect();
    let distinct: BTreeSet<u64> = numbers.iter().copied().collect();
    assert_eq!(numbers.len(), CLIENTS * EACH);
    assert!(distinct.into_iter().eq(1..=(CLIENTS * EACH) as u64));
    app.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn readers_and_writers_do_not_meet_a_locked_database() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let place = app.iteration(&job).await;
    let fit = app.get(&place).await.json()["fits"][0]["id"].clone();
    let mut requests = JoinSet::new();
    for i in 0..240 {
        let request = match i % 6 {
            0 => app.request(Method::POST, &format!("{job}/iterations")).json(&iteration()),
            1 => app.request(Method::GET, &format!("{job}/trace")),
            2 => app.request(Method::PATCH, &place).json(&json!({"decision": "accepted", "reason": i.to_string()})),
            3 => app.request(Method::PATCH, &job).json(&json!({"machine": i.to_string()})),
            4 => app
                .request(Method::PUT, &format!("{place}/chosen-fit"))
                .json(&json!({"fit_id": fit, "reason": i.to_string()})),
            _ => app.request(Method::GET, &place),
        };
        requests.spawn(send(request));
    }
    for answer in requests.join_all().await {
        assert!(answer.status.is_success(), "{}: {}", answer.status, answer.text);
    }
    let trace = app.get(&format!("{job}/trace")).await.json();
    assert_eq!(trace["iterations"].as_array().unwrap().len(), 41);
    assert_eq!(trace["iterations"][0]["decisions"].as_array().unwrap().len(), 40);
    assert_eq!(trace["iterations"][0]["choices"].as_array().unwrap().len(), 41);
    app.stop().await;
}
