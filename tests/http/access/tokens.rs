//! Tokens of an identity provider in the place of keys, over HTTP.

use std::time::{Duration, Instant};

use flankfit::{
    config::{OidcSettings, parse_networks},
    jobs::Role,
};
use reqwest::Method;
use serde_json::{Value, json};

use super::{
    callers::held_up,
    issuer::{Issuer, SigningKey, base64, hs256, now, unsigned},
    keys::key_of,
};
use crate::{
    harness::{Answer, CURVE, TestApp, ready, send},
    jobs::{events::Listener, socket},
    plant::proxy::free_address,
};

/// A server that accepts tokens of this provider, and believes a proxy here.
async fn accepting(issuer: &Issuer) -> TestApp {
    accepting_anew(issuer, OidcSettings::default().refresh).await
}

/// The same, with another time between two times that the provider is asked.
async fn accepting_anew(issuer: &Issuer, refresh: Duration) -> TestApp {
    TestApp::start_with(|settings| {
        settings.auth = flankfit::config::Authentication::Auto;
        settings.trusted_proxies = parse_networks("127.0.0.0/8").unwrap();
        settings.oidc = OidcSettings {
            issuer: Some(issuer.url.clone()),
            audience: Some(vec!["flankfit".into(), "cell".into()]),
            tenant_claim: Some("plant".into()),
            refresh,
            ..OidcSettings::default()
        };
    })
    .await
}

/// Who a token is, asked from an address of its own.
async fn whoami(app: &TestApp, token: &str) -> Answer {
    static ADDRESS: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(1);
    let address = ADDRESS.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    let from = std::net::Ipv4Addr::from(0xc612_0000 + address).to_string();
    send(app.get("/v1/whoami").bearer_auth(token).header("x-forwarded-for", from)).await
}

fn engineer() -> Value {
    json!({"role": "engineer", "plant": "default"})
}

#[tokio::test]
async fn every_algorithm_is_accepted() {
    let issuer = Issuer::start();
    let keys = [
        SigningKey::rsa("rs", "RS256"),
        SigningKey::rsa("ps", "PS256"),
        SigningKey::es256("es"),
        SigningKey::ed25519("ed"),
    ];
    issuer.publish(&keys.each_ref());
    let app = accepting(&issuer).await;
    for key in &keys {
        let expires = now() + 300;
        let mut claims = engineer();
        (claims["exp"], claims["sub"]) = (expires.into(), format!("jane of {}", key.name).into());
        let response = whoami(&app, &issuer.token(key, claims)).await;
        assert_eq!(response.status, 200, "{}: {}", key.algorithm, response.text);
        let expected = format!("{:.6}", jiff::Timestamp::from_second(expires as i64).unwrap());
        assert_eq!(
            response.json(),
            json!({
                "tenant": "default", "actor": format!("jane of {}", key.name), "kind": "token", "role": "engineer",
                "scopes": ["read", "compute", "measure", "decide"], "expires_at": expected,
            })
        );
    }
    // keys are still accepted, and identify themselves as such
    let key = key_of(&app, "default", Role::Reader).await;
    assert_eq!(whoami(&app, &key).await.json()["kind"], "secret");
    send(app.get("/v1/whoami")).await.problem(401, "unauthorized");
    // one set serves all, and was requested once
    assert_eq!(issuer.asked().len(), 1);
    app.stop().await;
}

/// Tokens with exactly one error each.
fn wrong_tokens(issuer: &Issuer, rs: &SigningKey, es: &SigningKey) -> Vec<(String, String)> {
    let stranger = SigningKey::rsa("rs", "RS256");
    let claims = |name: &str, value: Value| {
        let mut claims = issuer.claims(engineer());
        match value {
            Value::Null => _ = claims.as_object_mut().unwrap().remove(name),
            value => claims[name] = value,
        }
        rs.token(&rs.header(), &claims)
    };
    let header = |name: &str, value: Value| {
        let mut header = rs.header();
        header[name] = value;
        rs.token(&header, &issuer.claims(engineer()))
    };
    let good = issuer.token(rs, engineer());
    let (text, signature) = good.rsplit_once('.').unwrap();
    let other = unsigned(&rs.header(), &issuer.claims(json!({"role": "admin", "plant": "default"})));
    let mut wrong: Vec<(String, String)> = [
        ("another issuer", claims("iss", json!("http://127.0.0.1:1/realms/plant"))),
        ("several issuers", claims("iss", json!([issuer.url, "other"]))),
        ("no issuer", claims("iss", Value::Null)),
        ("another audience", claims("aud", json!("other"))),
        ("no audience", claims("aud", Value::Null)),
        ("expired", claims("exp", json!(now() - 25))),
        ("no end", claims("exp", Value::Null)),
        ("an end in words", claims("exp", json!("tomorrow"))),
        ("not yet", claims("nbf", json!(now() + 60))),
        ("no subject", claims("sub", Value::Null)),
        // names under which the service itself acts, and such as nobody reads right
        ("retention's name", claims("sub", json!("retention"))),
        ("nobody's name", claims("sub", json!("Anonymous"))),
        ("the name of the database's own", claims("sub", json!("keys create"))),
        ("the name of a key", claims("sub", json!("key-27042f4e6eca"))),
        ("a name read backwards", claims("sub", json!("nimda\u{202e}"))),
        ("a name of two lines", claims("sub", json!("jd\u{2028}admin"))),
        ("an empty name", claims("sub", json!(""))),
        ("a number as a name", claims("sub", json!(7))),
        ("a long name", claims("sub", json!("x".repeat(256)))),
        ("no role", claims("role", Value::Null)),
        ("a number as a role", claims("role", json!(7))),
        ("root and another role", claims("role", json!(["root", "admin"]))),
        ("a role of nobody", claims("role", json!("god"))),
        ("root of a tenant", claims("role", json!("root"))),
        ("no tenant", claims("plant", Value::Null)),
        ("a tenant that is not there", claims("plant", json!("nowhere"))),
        ("a tenant that cannot be", claims("plant", json!("@root"))),
        ("a tenant in capitals", claims("plant", json!("Plant"))),
        ("a list of tenants", claims("plant", json!(["default"]))),
        ("another algorithm of the key", header("alg", json!("RS512"))),
        ("the key's name is another's", header("kid", json!(es.name))),
        ("what must be understood", header("crit", json!(["b64"]))),
        (
            "a key of its own",
            stranger.token(&json!({"alg": "RS256", "jwk": stranger.public()}), &issuer.claims(engineer())),
        ),
        ("a stranger's signature", stranger.token(&rs.header(), &issuer.claims(engineer()))),
        ("another's signature", format!("{other}.{signature}")),
        ("no signature", format!("{text}.")),
        ("a signature that is cut", good[..good.len() - 4].to_owned()),
        ("nothing in it", "eyJ..".to_owned()),
        ("too long", format!("{text}.{}", "A".repeat(20_000))),
    ]
    .map(|(what, token)| (what.to_owned(), token))
    .into();
    for none in ["none", "None", "NONE", ""] {
        let text = unsigned(&json!({"alg": none, "kid": rs.name}), &issuer.claims(engineer()));
        wrong.push((format!("algorithm {none:?}"), format!("{text}.")));
        wrong.push((format!("algorithm {none:?}, signed"), format!("{text}.{signature}")));
    }
    for key in [rs, es] {
        for (form, secret) in key.public_bytes().into_iter().enumerate().filter(|(_, secret)| !secret.is_empty()) {
            wrong.push((
                format!("HS256 by the public key, form {form}"),
                hs256(&secret, &key.name, &issuer.claims(engineer())),
            ));
        }
    }
    wrong
}

#[tokio::test]
async fn invalid_tokens_are_refused() {
    let issuer = Issuer::start();
    let (rs, es) = (SigningKey::rsa("rs", "RS256"), SigningKey::es256("es"));
    issuer.publish(&[&rs, &es]);
    let app = accepting(&issuer).await;
    assert_eq!(whoami(&app, &issuer.token(&rs, engineer())).await.status, 200);
    let mut details = Vec::new();
    let wrong = wrong_tokens(&issuer, &rs, &es);
    assert!(wrong.len() > 35, "{}", wrong.len());
    for (what, token) in wrong {
        let answer = whoami(&app, &token).await;
        assert_eq!(answer.status, 401, "{what}: {}", answer.text);
        assert_eq!(answer.header("www-authenticate"), "Bearer error=\"invalid_token\"", "{what}");
        for part in token.split('.').filter(|part| part.len() > 20) {
            assert!(!answer.text.contains(part), "{what}");
        }
        let problem = answer.problem(401, "invalid_key");
        assert_eq!(problem["title"], "The API key or token cannot be used", "{what}");
        // what has not even the form of a token is taken for a key
        if token.split('.').count() == 3 && token.starts_with("ey") {
            details.push(problem["detail"].as_str().unwrap().to_owned());
        }
    }
    details.dedup();
    assert_eq!(details.len(), 1, "one text for all: {details:?}");
    // a little is forgiven to clocks, a list may name the audience, and a key need not be named
    for good in [json!({"exp": now() - 10}), json!({"nbf": now() + 15}), json!({"aud": ["other", "cell"]})] {
        let mut claims = issuer.claims(engineer());
        claims.as_object_mut().unwrap().extend(good.as_object().unwrap().clone());
        assert_eq!(whoami(&app, &rs.token(&rs.header(), &claims)).await.status, 200, "{good}");
    }
    let unnamed = es.token(&json!({"alg": "ES256"}), &issuer.claims(engineer()));
    assert_eq!(whoami(&app, &unnamed).await.status, 200);
    // tokens are no keys
    let good = issuer.token(&rs, engineer());
    send(app.get("/v1/whoami").header("x-api-key", &good)).await.problem(401, "invalid_key");
    app.stop().await;
}

#[tokio::test]
async fn unknown_keys_are_fetched_at_most_once_a_minute() {
    let issuer = Issuer::start();
    let (old, new) = (SigningKey::es256("old"), SigningKey::es256("new"));
    issuer.publish(&[&old]);
    let app = accepting(&issuer).await;
    let before = issuer.token(&old, engineer());
    assert_eq!(whoami(&app, &before).await.status, 200);
    assert_eq!(issuer.asked().len(), 1);
    // the provider has other keys now: the first token of one is believed at once
    issuer.publish(&[&new]);
    assert_eq!(whoami(&app, &issuer.token(&new, engineer())).await.status, 200);
    assert_eq!(issuer.asked().len(), 2);
    // what the key signed that it has no more is not believed any more, although it was
    whoami(&app, &before).await.problem(401, "invalid_key");
    for k in 0..20 {
        let unknown = SigningKey::ed25519(&format!("unknown {k}"));
        whoami(&app, &issuer.token(&unknown, engineer())).await.problem(401, "invalid_key");
    }
    let stranger = SigningKey::es256("new");
    whoami(&app, &issuer.token(&stranger, engineer())).await.problem(401, "invalid_key");
    assert_eq!(issuer.asked().len(), 2);
    app.stop().await;
}

/// Without a token that names a key nobody knows, the provider is asked by the clock alone.
#[tokio::test]
async fn a_withdrawn_key_is_refused_after_the_next_fetch() {
    let issuer = Issuer::start();
    let (old, new) = (SigningKey::es256("old"), SigningKey::es256("new"));
    issuer.publish(&[&old]);
    let app = accepting_anew(&issuer, Duration::from_secs(1)).await;
    let token = issuer.token(&old, engineer());
    assert_eq!(whoami(&app, &token).await.status, 200);
    issuer.publish(&[&new]);
    let begun = Instant::now();
    let refused = loop {
        let answer = whoami(&app, &token).await;
        if answer.status != 200 {
            break answer;
        }
        assert!(begun.elapsed() < Duration::from_secs(60), "its key is known for ever");
        tokio::time::sleep(Duration::from_millis(50)).await;
    };
    refused.problem(401, "invalid_key");
    assert_eq!(whoami(&app, &issuer.token(&new, engineer())).await.status, 200);
    app.stop().await;
}

#[tokio::test]
async fn roles_of_tokens_are_those_of_keys() {
    let issuer = Issuer::start();
    let key = SigningKey::es256("one");
    issuer.publish(&[&key]);
    let app = accepting(&issuer).await;
    let cells = [
        ("reader", [200, 403, 200, 403, 403, 403]),
        ("operator", [200, 201, 200, 403, 403, 403]),
        ("engineer", [200, 201, 200, 403, 403, 403]),
        ("auditor", [200, 403, 403, 200, 403, 403]),
        ("admin", [200, 403, 403, 200, 200, 403]),
        ("root", [403, 403, 403, 403, 403, 200]),
    ];
    for (role, expected) in cells {
        let claims = if role == "root" { json!({"role": role}) } else { json!({"role": role, "plant": "default"}) };
        let token = issuer.token(&key, claims);
        let requests = [
            app.get("/v1/jobs"),
            app.post("/v1/jobs", r#"{"name":"wheel"}"#),
            app.post("/v1/fits", CURVE),
            app.get("/v1/audit"),
            app.get("/v1/keys"),
            app.get("/v1/tenants"),
        ];
        for (request, expected) in requests.into_iter().zip(expected) {
            let answer = send(request.bearer_auth(&token)).await;
            assert_eq!(answer.status, expected, "{role}: {}", answer.text);
            if expected == 403 {
                assert_eq!(answer.header("www-authenticate"), "Bearer error=\"insufficient_scope\"");
            }
        }
    }
    // an admin by a token makes keys of every role of the tenant, and no root
    let admin = issuer.token(&key, json!({"role": "admin", "plant": "default"}));
    let make =
        |role: &str| send(app.post("/v1/keys", json!({"name": "k", "role": role}).to_string()).bearer_auth(&admin));
    assert_eq!(make("engineer").await.status, 201);
    assert!(make("root").await.status.is_client_error());
    // and the trace of the job names the subject
    let entries = send(app.get("/v1/audit").bearer_auth(&admin)).await.json();
    assert!(entries["items"].as_array().unwrap().iter().any(|entry| entry["actor"] == "jane.doe"), "{entries}");
    app.stop().await;
}

#[tokio::test]
async fn a_token_is_of_its_tenant_as_long_as_that_is_let_in() {
    let issuer = Issuer::start();
    let key = SigningKey::ed25519("one");
    issuer.publish(&[&key]);
    let app = accepting(&issuer).await;
    let root = issuer.token(&key, json!({"role": "root"}));
    let of = |plant: &str| issuer.token(&key, json!({"role": "engineer", "plant": plant}));
    whoami(&app, &of("plant-7")).await.problem(401, "invalid_key");
    let made = send(app.post("/v1/tenants", r#"{"name":"plant-7"}"#).bearer_auth(&root)).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let (own, other) = (of("plant-7"), of("default"));
    assert_eq!(whoami(&app, &own).await.json()["tenant"], "plant-7");
    let job = send(app.post("/v1/jobs", r#"{"name":"wheel"}"#).bearer_auth(&own)).await.header("location").to_owned();
    assert_eq!(send(app.get(&job).bearer_auth(&own)).await.status, 200);
    send(app.get(&job).bearer_auth(&other)).await.problem(404, "not_found");
    let suspend = app.client.request(Method::PATCH, app.url("/v1/tenants/plant-7")).bearer_auth(&root);
    assert_eq!(send(suspend.json(&json!({"suspended": true}))).await.status, 200);
    whoami(&app, &own).await.problem(401, "invalid_key");
    assert_eq!(whoami(&app, &other).await.status, 200);
    app.stop().await;
}

#[tokio::test]
async fn a_peer_that_guesses_tokens_is_held_up_and_a_good_one_is_not() {
    let issuer = Issuer::start();
    let (key, stranger) = (SigningKey::es256("one"), SigningKey::es256("one"));
    issuer.publish(&[&key]);
    let app = accepting(&issuer).await;
    let ask = |token: String| send(app.get("/v1/whoami").bearer_auth(token));
    let held = held_up(|_| ask(issuer.token(&stranger, engineer()))).await;
    held.problem(429, "too_many_requests");
    assert_eq!(ask(issuer.token(&key, engineer())).await.status, 200);
    app.stop().await;
}

#[tokio::test]
async fn open_connections_end_with_their_token() {
    let issuer = Issuer::start();
    let key = SigningKey::es256("one");
    issuer.publish(&[&key]);
    let app = accepting(&issuer).await;
    let lasting = issuer.token(&key, engineer());
    let post = |path: &str, body: &Value| send(app.post(path, body.to_string()).bearer_auth(&lasting));
    let job = post("/v1/jobs", &json!({"name": "wheel"})).await.header("location").to_owned();
    let stream = post(&format!("{job}/streams"), &crate::jobs::streams::spec()).await.header("location").to_owned();
    // of what is forgiven to clocks ten seconds are left, for a busy machine to open all of these
    let expired = now() - 10;
    let mut claims = engineer();
    claims["exp"] = expired.into();
    let short = issuer.token(&key, claims);
    let mut listener = Listener::of(app.get(&format!("{job}/events")).bearer_auth(&short), None).await.unwrap();
    assert!(listener.next().await.is_some(), "the stream was opened");
    let mut socket = socket::connect_with(&format!("http://{}", app.address), &stream, &short).await;
    assert_eq!(socket::close(&mut socket).await.map(u16::from), Some(1008));
    assert!(listener.next().await.is_none());
    // with the delays of a busy machine
    assert!((expired + 20..expired + 50).contains(&now()), "{} s after its end", now() - expired);
    app.stop().await;
}

/// It starts, computes and lets in keys; and tokens as soon as the provider is there.
#[tokio::test]
async fn a_server_does_not_need_its_provider_to_start() {
    let address = free_address();
    let url = format!("http://{address}/realms/plant");
    let key = SigningKey::es256("one");
    let app = TestApp::start_with(|settings| {
        settings.auth = flankfit::config::Authentication::Auto;
        settings.oidc = OidcSettings {
            issuer: Some(url.clone()),
            audience: Some(vec!["flankfit".into()]),
            ..OidcSettings::default()
        };
    })
    .await;
    let claims = json!({"iss": url, "aud": "flankfit", "sub": "jane", "exp": now() + 600, "role": "reader"});
    let token = key.token(&key.header(), &claims);
    let refused = whoami(&app, &token).await;
    refused.problem(503, "issuer_unavailable");
    assert_eq!(refused.header("retry-after"), "15");
    ready(&app.get("/readyz")).await;
    let secret = key_of(&app, "default", Role::Reader).await;
    assert_eq!(send(app.post("/v1/fits", CURVE).bearer_auth(&secret)).await.status, 200);
    let issuer = Issuer::on(std::net::TcpListener::bind(address).unwrap());
    issuer.publish(&[&key]);
    let begun = Instant::now();
    while whoami(&app, &token).await.status != 200 {
        assert!(begun.elapsed() < Duration::from_secs(120), "it is not asked again");
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
    app.stop().await;
}

#[tokio::test]
async fn a_provider_that_is_another_is_not_believed() {
    let issuer = Issuer::start();
    let key = SigningKey::es256("one");
    issuer.publish(&[&key]);
    issuer.pretend("https://other.example");
    let app = accepting(&issuer).await;
    whoami(&app, &issuer.token(&key, engineer())).await.problem(503, "issuer_unavailable");
    assert!(issuer.asked().is_empty());
    // with a given address of the keys no discovery takes place
    let configured = TestApp::start_with(|settings| {
        settings.auth = flankfit::config::Authentication::Required;
        let root = issuer.url.trim_end_matches("/realms/plant");
        settings.oidc = OidcSettings {
            issuer: Some(issuer.url.clone()),
            audience: Some(vec!["flankfit".into()]),
            jwks_url: Some(format!("{root}/keys")),
            ..OidcSettings::default()
        };
    })
    .await;
    assert_eq!(whoami(&configured, &issuer.token(&key, engineer())).await.json()["actor"], "jane.doe");
    let keyless = format!("{}.{}", base64(b"{}"), base64(b"{}"));
    whoami(&configured, &keyless).await.problem(401, "invalid_key");
    app.stop().await;
    configured.stop().await;
}

#[tokio::test]
async fn the_provider_is_reached_over_tls() {
    let (issuer, certificate) = Issuer::by_tls();
    let key = SigningKey::ed25519("one");
    issuer.publish(&[&key]);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ca.pem");
    std::fs::write(&file, certificate).unwrap();
    for authorities in [Some(file), None] {
        let is_known = authorities.is_some();
        let app = TestApp::start_with(|settings| {
            settings.auth = flankfit::config::Authentication::Auto;
            settings.oidc = OidcSettings {
                issuer: Some(issuer.url.clone()),
                audience: Some(vec!["flankfit".into()]),
                authorities,
                ..OidcSettings::default()
            };
        })
        .await;
        let response = whoami(&app, &issuer.token(&key, json!({"role": "reader"}))).await;
        match is_known {
            true => assert_eq!(response.json()["kind"], "token", "{}", response.text),
            false => _ = response.problem(503, "issuer_unavailable"),
        }
        app.stop().await;
    }
}
