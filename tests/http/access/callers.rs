//! Rates of requests of callers, and of refusals of a peer without a key.

use std::{
    num::NonZeroU32,
    time::{Duration, Instant},
};

use flankfit::config::{Digest, parse_networks};
use serde_json::Value;
use sha2::Digest as _;

use super::talkative::Talkative;
use crate::harness::{Answer, CURVE, TestApp, send};

fn digest(key: &str) -> Digest {
    Digest(sha2::Sha256::digest(key).into())
}

#[tokio::test]
async fn each_key_has_its_share_of_requests() {
    let app = TestApp::start_with(|settings| {
        settings.api_keys_sha256 = vec![digest("one"), digest("other")];
        settings.rate_limit = NonZeroU32::new(20);
        settings.rate_burst = NonZeroU32::new(3);
    })
    .await;
    let fit = |key: &'static str| send(app.post("/v1/fits", CURVE).bearer_auth(key));
    let mut made = 0;
    let refused = loop {
        let answer = fit("one").await;
        if answer.status != 200 {
            break answer;
        }
        made += 1;
        assert!(made < 500, "nobody is refused");
    };
    assert!(made >= 3, "refused after {made}");
    refused.problem(429, "too_many_requests");
    assert_eq!(refused.header("retry-after"), "1");
    assert_eq!(fit("other").await.status, 200);
    assert_eq!(send(app.get("/healthz")).await.status, 200);
    // a refusal uses up nothing, so that who goes on asking is served again
    let mut asked = 0;
    while fit("one").await.status != 200 {
        asked += 1;
        assert!(asked < 100_000, "nobody is served again");
    }
}

#[tokio::test]
async fn rate_limited_callers_are_named_in_the_log() {
    let folder = tempfile::tempdir().unwrap();
    let digest: String = digest("one").0.iter().map(|byte| format!("{byte:02x}")).collect();
    let arguments = ["--api-keys-sha256", &digest, "--rate-limit", "1"];
    let server = Talkative::start(&folder.path().join("test.db"), &arguments);
    let client = reqwest::Client::builder().no_proxy().build().unwrap();
    let begun = Instant::now();
    let refused = loop {
        let answer = send(client.get(format!("{}/v1/jobs", server.base)).bearer_auth("one")).await;
        if answer.status == 429 {
            break answer;
        }
        assert!(begun.elapsed() < Duration::from_secs(30), "nobody is refused");
    };
    let lines = server.end();
    let mut lines = lines.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let line = lines.find(|line| line["status"] == 429).expect("a line of the refusal");
    assert_eq!(line["request_id"], refused.header("x-request-id"));
    assert_eq!(line["actor"], format!("key-{}", &digest[..12]), "{line}");
}

#[tokio::test]
async fn without_keys_addresses_count_which_trusted_proxies_name() {
    let limits = |trusted: &'static str| {
        TestApp::start_with(move |settings| {
            settings.rate_limit = NonZeroU32::new(1);
            settings.trusted_proxies = parse_networks(trusted).unwrap();
        })
    };
    let behind = |app: &TestApp, client: &str| send(app.post("/v1/fits", CURVE).header("x-forwarded-for", client));
    // one request a second: a machine that takes longer for two is asked again, by other addresses
    let until_refused = async |app: &TestApp, client: &dyn Fn(u32) -> String| {
        let begun = Instant::now();
        for number in 0.. {
            let answer = behind(app, &client(number)).await;
            if answer.status != 200 {
                answer.problem(429, "too_many_requests");
                return;
            }
            assert!(begun.elapsed() < Duration::from_secs(60), "{} is not refused", client(number));
        }
    };
    let trusting = limits("127.0.0.0/8").await;
    assert_eq!(behind(&trusting, "192.0.2.1").await.status, 200);
    until_refused(&trusting, &|_| "192.0.2.1".to_owned()).await;
    assert_eq!(behind(&trusting, "192.0.2.2").await.status, 200);
    // what the client wrote before the proxy did is not believed
    until_refused(&trusting, &|number| format!("198.18.{}.{}, 192.0.2.1", number / 256 % 256, number % 256)).await;
    let other = limits("").await;
    assert_eq!(behind(&other, "192.0.2.1").await.status, 200);
    until_refused(&other, &|number| format!("198.18.{}.{}", number / 256 % 256, number % 256)).await;
}

/// Guesses until the peer is held up: the answer to the guess that is not judged any more.
pub async fn held_up<F: Future<Output = Answer>>(ask: impl Fn(u64) -> F) -> Answer {
    let (mut guessed, begun) = (0, Instant::now());
    let held = loop {
        let answer = ask(guessed).await;
        if answer.status != 401 {
            break answer;
        }
        answer.problem(401, "invalid_key");
        guessed += 1;
        assert!(guessed < 100, "nobody is held up");
    };
    // one more is granted for every six seconds that this takes
    let granted = 10 + begun.elapsed().as_secs() / 6 + 1;
    assert!((10..=granted).contains(&guessed), "held up after {guessed}");
    held
}

#[tokio::test]
async fn a_peer_that_guesses_is_held_up_and_a_good_key_is_not() {
    let app = TestApp::start_with(|settings| settings.api_keys_sha256 = vec![digest("right")]).await;
    let fit = |key: String| send(app.post("/v1/fits", CURVE).bearer_auth(key));
    let held = held_up(|guess| fit(format!("guess {guess}"))).await;
    held.problem(429, "too_many_requests");
    assert!(held.header("retry-after").parse::<u32>().is_ok_and(|seconds| (1..=6).contains(&seconds)));
    assert_eq!(fit("right".into()).await.status, 200);
    send(app.post("/v1/fits", CURVE)).await.problem(429, "too_many_requests");
}
