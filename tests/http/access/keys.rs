//! API keys from their making to their end, over HTTP and by the command line.

use std::time::{Duration, Instant};

use flankfit::{
    app::App,
    config::{Authentication, Digest, ServeSettings},
    http::AppState,
    jobs::{Caller, Clock, KeyDraft, Role, SystemClock, Tenant},
};
use jiff::{SignedDuration, Timestamp};
use reqwest::{Method, RequestBuilder};
use serde_json::{Value, json};

use crate::{
    harness::{Answer, CURVE, TestApp, send},
    heard::Heard,
    jobs::{events::Listener, socket},
    program::program,
};

/// A key made on the database.
pub async fn key_of(app: &TestApp, tenant: &str, role: Role) -> String {
    key_on(&app.state, tenant, role).await
}

/// The same by what a server's handlers reach.
pub async fn key_on(state: &AppState, tenant: &str, role: Role) -> String {
    let tenant = if role == Role::Root { Tenant::root() } else { Tenant::named(tenant).unwrap() };
    let keys = state.jobs.keys_of(&Caller { tenant, actor: "test".into(), origin: Default::default() });
    let draft =
        KeyDraft { name: role.name().to_owned(), role: Some(role), scopes: role.scopes(), expires_at: None, san: None };
    keys.create(draft, None).await.unwrap().1.unwrap().expose().to_owned()
}

async fn start() -> TestApp {
    TestApp::start_with(|settings| settings.auth = Authentication::Required).await
}

fn request(app: &TestApp, key: &str, method: Method, path: &str, body: &Value) -> RequestBuilder {
    app.client.request(method, app.url(path)).bearer_auth(key).json(body)
}

async fn post(app: &TestApp, key: &str, path: &str, body: &Value) -> Answer {
    send(request(app, key, Method::POST, path, body)).await
}

async fn get(app: &TestApp, key: &str, path: &str) -> Answer {
    send(app.get(path).bearer_auth(key)).await
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_else(|| panic!("{value}")).to_owned()
}

/// A server open to the network without a key logs a warning.
#[tokio::test]
async fn a_server_that_lets_everybody_in_warns_off_loopback() {
    for (address, auth, keys, warns) in [
        ("0.0.0.0:0", Authentication::Auto, 0, true),
        ("0.0.0.0:0", Authentication::Off, 0, true),
        ("127.0.0.1:0", Authentication::Auto, 0, false),
        ("0.0.0.0:0", Authentication::Auto, 1, false),
        ("0.0.0.0:0", Authentication::Required, 0, false),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let settings = ServeSettings {
            bind: address.parse().unwrap(),
            database_url: crate::database::in_file(&folder.path().join("test.db")),
            workers: 1,
            auth,
            api_keys_sha256: vec![Digest([0; 32]); keys],
            ..ServeSettings::default()
        };
        let (heard, _while_heard) = Heard::here();
        let app = App::start(settings).await.unwrap();
        let said = heard.take();
        assert_eq!(said.contains("WARN") && said.contains("no key is required"), warns, "{address} {auth:?}: {said}");
        drop(app);
    }
}

#[tokio::test]
async fn a_key_from_its_making_to_its_end() {
    let app = start().await;
    let admin = key_of(&app, "default", Role::Admin).await;
    let expires = SystemClock.now() + SignedDuration::from_hours(1000);
    let body = json!({"name": "grinder 3", "role": "operator", "expires_at": expires.to_string()});
    let made = post(&app, &admin, "/v1/keys", &body).await;
    assert_eq!((made.status.as_u16(), made.header("cache-control")), (201, "no-store"), "{}", made.text);
    let (key, place) = (made.json(), made.header("location").to_owned());
    let secret = text(&key["key"]);
    assert!(secret.starts_with(&format!("ffk_{}_", text(&key["id"]))) && secret.len() == 93);
    assert_eq!(
        (&key["tenant"], &key["kind"], &key["scopes"]),
        (&"default".into(), &"secret".into(), &json!(["read", "compute", "measure"]))
    );

    let seen = get(&app, &admin, &place).await;
    assert_eq!((seen.header("etag"), seen.header("cache-control")), ("\"1\"", "no-store"));
    assert!(seen.json().get("key").is_none() && !seen.text.contains(&secret[21..85]), "{}", seen.text);
    let listed = get(&app, &admin, "/v1/keys").await.json();
    assert_eq!(listed["items"].as_array().unwrap().len(), 2);
    assert_eq!((&listed["items"][0]["id"], listed["items"][0].get("key")), (&key["id"], None));

    let patch = |tag: &'static str, body: Value| {
        send(request(&app, &admin, Method::PATCH, &place, &body).header("if-match", tag))
    };
    let renamed = patch("\"1\"", json!({"name": "grinder 4"})).await;
    assert_eq!((renamed.json()["name"].clone(), renamed.header("etag")), ("grinder 4".into(), "\"2\""));
    patch("\"1\"", json!({"name": "grinder 5"})).await.problem(412, "precondition_failed");
    assert_eq!(patch("*", json!({"expires_at": "2020-01-01T00:00:00Z"})).await.pointers(), ["/expires_at"]);

    // a second secret, and for a while both
    let rotated = post(&app, &admin, &format!("{place}/rotate"), &json!({"overlap_seconds": 8})).await;
    assert_eq!(rotated.status, 201, "{}", rotated.text);
    let new = text(&rotated.json()["key"]);
    assert_eq!(rotated.json()["name"], "grinder 4");
    assert!(text(&rotated.json()["expires_at"]).as_str() > "2026");
    assert_eq!(get(&app, &new, "/v1/jobs").await.status, 200);
    let began = Instant::now();
    assert_eq!(get(&app, &secret, "/v1/jobs").await.status, 200);
    while get(&app, &secret, "/v1/jobs").await.status == 200 {
        assert!(began.elapsed() < Duration::from_secs(60), "the overlap is over");
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    get(&app, &secret, "/v1/jobs").await.problem(401, "invalid_key");

    // and no more: kept, but never used again
    let place = format!("/v1/keys/{}", text(&rotated.json()["id"]));
    assert_eq!(send(request(&app, &admin, Method::DELETE, &place, &json!({}))).await.status, 204);
    get(&app, &new, "/v1/jobs").await.problem(401, "invalid_key");
    assert!(get(&app, &admin, &place).await.json()["revoked_at"].is_string());
    assert_eq!(send(request(&app, &admin, Method::DELETE, &place, &json!({}))).await.status, 204);
    let again = post(&app, &admin, &format!("{place}/rotate"), &json!({"overlap_seconds": 0})).await;
    again.problem(409, "conflict");
    for path in ["/v1/keys/0123456789abcdef", "/v1/keys/nothing", "/v1/keys/0123456789ABCDEF"] {
        get(&app, &admin, path).await.problem(404, "not_found");
    }
    // all that was done is in the chain of the tenant, and no secret
    let audit = get(&app, &admin, "/v1/audit").await;
    let entries = audit.json()["items"].as_array().unwrap().clone();
    let actions: Vec<_> = entries.iter().map(|entry| entry["action"].as_str().unwrap()).collect();
    assert_eq!(actions, ["key.create", "key.create", "key.change", "key.rotate", "key.revoke"]);
    let actor = format!("key-{}", &admin[4..20]);
    assert!(
        entries[1..].iter().all(|entry| entry["actor"] == *actor && entry["peer"] == "127.0.0.1"),
        "{}",
        audit.text
    );
    assert_eq!(entries[4]["subject"], *place);
    assert!([&admin, &secret, &new].iter().all(|key| !audit.text.contains(&key[21..85])));
    assert!(entries[1].get("request_id").is_some());
    app.stop().await;
}

/// A client that lost the new secret rotates the new key: the old one has its lifetime no more.
#[tokio::test]
async fn a_key_is_replaced_once_and_does_not_come_back() {
    let app = start().await;
    let admin = key_of(&app, "default", Role::Admin).await;
    let make = async |body: Value| post(&app, &admin, "/v1/keys", &body).await;
    let rotate = async |place: &str, overlap: u32| {
        post(&app, &admin, &format!("{place}/rotate"), &json!({"overlap_seconds": overlap})).await
    };
    let patch = async |place: &str, body: Value| send(request(&app, &admin, Method::PATCH, place, &body)).await;
    let refusal = |answer: &Answer| text(&answer.problem(409, "conflict")["detail"]);
    let later = |seconds| (SystemClock.now() + SignedDuration::from_secs(seconds)).to_string();

    for overlap in [0, 3600] {
        let made = make(json!({"name": "press 7", "role": "reader"})).await;
        let (old, secret) = (made.header("location").to_owned(), text(&made.json()["key"]));
        let lost = rotate(&old, overlap).await;
        let new = lost.header("location").to_owned();
        assert_eq!((lost.status.as_u16(), lost.json().get("expires_at")), (201, None), "{}", lost.text);
        let replaced = get(&app, &admin, &old).await.json();
        assert_eq!(replaced["replaced_by"], lost.json()["id"]);
        let listed = get(&app, &admin, "/v1/keys").await.json()["items"].as_array().unwrap().len();
        let message = refusal(&rotate(&old, overlap).await);
        assert!(message.contains(&text(&lost.json()["id"])) && message.contains("rotate"), "{message}");
        let longer = refusal(&patch(&old, json!({"expires_at": later(36_000)})).await);
        assert!(longer.contains(if overlap == 0 { "expired at" } else { "has replaced" }), "{longer}");
        assert_eq!(get(&app, &admin, "/v1/keys").await.json()["items"].as_array().unwrap().len(), listed);
        assert_eq!(get(&app, &secret, "/v1/jobs").await.status, if overlap == 0 { 401 } else { 200 });
        // as long as the first was made to live
        let again = rotate(&new, 0).await;
        assert_eq!((again.status.as_u16(), again.json().get("expires_at")), (201, None), "{}", again.text);
        assert_eq!(get(&app, &text(&again.json()["key"]), "/v1/jobs").await.status, 200);
        // while it goes on it may have another name, and an earlier end
        let sooner = patch(&old, json!({"name": "press 7, old", "expires_at": later(60)})).await;
        assert_eq!(sooner.status, if overlap == 0 { 409 } else { 200 }, "{}", sooner.text);
    }

    // one that has ended by itself is not changed, either
    let made = make(json!({"name": "press 8", "role": "reader", "expires_at": later(3)})).await;
    let (place, secret, began) = (made.header("location").to_owned(), text(&made.json()["key"]), Instant::now());
    while get(&app, &secret, "/v1/jobs").await.status == 200 {
        assert!(began.elapsed() < Duration::from_secs(60), "it has ended");
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    let ended = text(&made.json()["expires_at"]);
    for answer in [
        rotate(&place, 0).await,
        patch(&place, json!({"expires_at": later(3600)})).await,
        patch(&place, json!({"name": "press 9"})).await,
    ] {
        assert_eq!(refusal(&answer), format!("The key expired at {ended} for good; create a new one."));
    }
    get(&app, &secret, "/v1/jobs").await.problem(401, "invalid_key");
    app.stop().await;
}

/// One text for whatever is wrong with a key.
#[tokio::test]
async fn invalid_keys_get_the_same_response() {
    let app = start().await;
    let (admin, other) = (key_of(&app, "default", Role::Admin).await, key_of(&app, "default", Role::Reader).await);
    let slip = format!("{}{}", &other[..92], if other.ends_with('0') { '1' } else { '0' });
    let mut unknown = other.clone().into_bytes();
    unknown[30] = if unknown[30] == b'0' { b'1' } else { b'0' };
    let crc = crc32fast::hash(&unknown[..85]);
    let unproven = format!("{}{crc:08x}", String::from_utf8(unknown[..85].to_vec()).unwrap());
    let nobody = format!("ffk_0123456789abcdef_{}", "0".repeat(64));
    let nobody = format!("{nobody}{:08x}", crc32fast::hash(nobody.as_bytes()));
    let id = other[4..20].to_owned();
    let mut details = Vec::new();
    for wrong in [&slip, &unproven, &nobody, "nonsense"] {
        details.push(get(&app, wrong, "/v1/jobs").await.problem(401, "invalid_key")["detail"].clone());
    }
    assert_eq!(get(&app, &other, "/v1/jobs").await.status, 200);
    assert_eq!(send(request(&app, &admin, Method::DELETE, &format!("/v1/keys/{id}"), &json!({}))).await.status, 204);
    details.push(get(&app, &other, "/v1/jobs").await.problem(401, "invalid_key")["detail"].clone());
    assert!(details.iter().all(|one| *one == details[0]), "{details:?}");
    app.stop().await;
}

/// Refusals name the admissible values, and the bounds that hold.
#[tokio::test]
async fn refusals_list_the_admissible_values() {
    let app = start().await;
    let admin = key_of(&app, "default", Role::Admin).await;
    for (body, pointer, ends) in [
        (json!({"name": "n", "role": "engi"}), "/role", "`auditor`, `admin`"),
        (json!({"name": "n", "role": true}), "/role", "`auditor`, `admin` in quotes, found a boolean"),
        (json!({"name": "n", "scopes": ["read", "reed"]}), "/scopes/1", "`audit`, `admin`"),
        (json!({"name": "n", "role": "root"}), "/role", "`auditor`, `admin`"),
        (json!({"name": "n", "scopes": ["tenants"]}), "/scopes/0", "`audit`, `admin`"),
    ] {
        let refused = post(&app, &admin, "/v1/keys", &body).await;
        assert_eq!(refused.pointers(), [pointer], "{body}");
        let detail = text(&refused.json()["errors"][0]["detail"]);
        assert!(detail.contains(ends), "{detail}");
    }
    let place = format!("/v1/keys/{}/rotate", &admin[4..20]);
    for (overlap, found) in [(-1_i64, "-1"), (2_592_001, "2592001"), (4_294_967_296, "4294967296")] {
        let refused = post(&app, &admin, &place, &json!({"overlap_seconds": overlap})).await;
        assert_eq!(refused.pointers(), ["/overlap_seconds"]);
        let detail = text(&refused.json()["errors"][0]["detail"]);
        assert_eq!(detail, format!("expected a whole number from 0 to 2592000, found {found}"));
    }
    app.stop().await;
}

#[tokio::test]
async fn rights_of_a_new_key_are_specified_once() {
    let app = start().await;
    let admin = key_of(&app, "default", Role::Admin).await;
    for (body, wrong) in [
        (json!({"name": "n"}), &["/role"][..]),
        (json!({"name": "n", "role": "reader", "scopes": ["read"]}), &["/scopes"]),
        (json!({"name": "n", "scopes": []}), &["/scopes"]),
        (json!({"name": "n", "role": "reader", "san": "x"}), &["/san"]),
        (json!({"name": "n", "role": "reader", "kind": "certificate"}), &["/san"]),
        (
            json!({"name": "n", "kind": "certificate", "san": "*.x", "expires_at": "2020-11-23T12:00:00Z"}),
            &["/role", "/san", "/expires_at"],
        ),
    ] {
        assert_eq!(post(&app, &admin, "/v1/keys", &body).await.pointers(), wrong, "{body}");
    }
    app.stop().await;
}

#[tokio::test]
async fn nobody_grants_rights_that_they_lack() {
    let app = start().await;
    let admin = key_of(&app, "default", Role::Admin).await;
    for role in ["reader", "operator", "engineer", "auditor", "admin"] {
        let made = post(&app, &admin, "/v1/keys", &json!({"name": role, "role": role})).await;
        assert_eq!(made.status, 201, "{role}: {}", made.text);
    }
    let limited = json!({"name": "limited", "scopes": ["read", "admin"]});
    let limited = text(&post(&app, &admin, "/v1/keys", &limited).await.json()["key"]);
    assert_eq!(post(&app, &limited, "/v1/keys", &json!({"name": "n", "scopes": ["admin"]})).await.status, 201);
    let engineer = post(&app, &admin, "/v1/keys", &json!({"name": "e", "role": "engineer"})).await;
    let place = engineer.header("location").to_owned();
    for (method, path, body) in [
        (Method::POST, "/v1/keys", json!({"name": "n", "scopes": ["read", "decide"]})),
        (Method::POST, "/v1/keys", json!({"name": "n", "role": "engineer"})),
        (Method::POST, &format!("{place}/rotate"), json!({"overlap_seconds": 0})),
        (Method::PATCH, &place, json!({"name": "mine"})),
    ] {
        let answer = send(request(&app, &limited, method, path, &body)).await;
        let detail = text(&answer.problem(403, "forbidden")["detail"]);
        assert!(detail.contains("`decide`") || detail.contains("`compute`"), "{detail}");
        assert_eq!(answer.header("www-authenticate"), "Bearer error=\"insufficient_scope\"");
    }
    app.stop().await;
}

#[tokio::test]
async fn tenants_are_made_by_root_and_see_their_own() {
    let app = start().await;
    let root = key_of(&app, "", Role::Root).await;
    let made = post(&app, &root, "/v1/tenants", &json!({"name": "plant-7"})).await;
    assert_eq!((made.status.as_u16(), made.header("location")), (201, "/v1/tenants/plant-7"), "{}", made.text);
    let admin = text(&made.json()["admin_key"]["key"]);
    post(&app, &root, "/v1/tenants", &json!({"name": "plant-7"})).await.problem(409, "conflict");
    assert_eq!(post(&app, &root, "/v1/tenants", &json!({"name": "Plant 8"})).await.pointers(), ["/name"]);
    let who = get(&app, &admin, "/v1/whoami").await.json();
    assert_eq!((&who["tenant"], &who["role"]), (&"plant-7".into(), &"admin".into()));

    // their jobs and keys do not meet
    let engineer = |key: Answer| text(&key.json()["key"]);
    let theirs = engineer(post(&app, &admin, "/v1/keys", &json!({"name": "e", "role": "engineer"})).await);
    let own = key_of(&app, "default", Role::Engineer).await;
    let job = post(&app, &theirs, "/v1/jobs", &json!({"name": "wheel"})).await.header("location").to_owned();
    assert_eq!(get(&app, &theirs, &job).await.status, 200);
    get(&app, &own, &job).await.problem(404, "not_found");
    assert_eq!(get(&app, &own, "/v1/jobs").await.json()["items"], json!([]));
    let other_admin = key_of(&app, "default", Role::Admin).await;
    get(&app, &other_admin, &format!("/v1/keys/{}", &theirs[4..20])).await.problem(404, "not_found");

    // and a suspended tenant is let in by none of its keys
    let patch = async |suspended: bool| {
        let body = json!({"suspended": suspended});
        let answer = send(request(&app, &root, Method::PATCH, "/v1/tenants/plant-7", &body)).await;
        assert_eq!(answer.json()["suspended"], suspended, "{}", answer.text);
    };
    patch(true).await;
    get(&app, &theirs, &job).await.problem(401, "invalid_key");
    assert_eq!(get(&app, &own, "/v1/jobs").await.status, 200);
    patch(false).await;
    assert_eq!(get(&app, &theirs, &job).await.status, 200);
    let names: Vec<Value> = get(&app, &root, "/v1/tenants").await.json()["items"]
        .as_array()
        .unwrap()
        .iter()
        .map(|t| t["name"].clone())
        .collect();
    assert_eq!(names, ["plant-7", "default"]);
    app.stop().await;
}

/// Connections that stay open end when their key does.
#[tokio::test]
async fn open_connections_end_with_their_key() {
    let app = start().await;
    let (admin, key) = (key_of(&app, "default", Role::Admin).await, key_of(&app, "default", Role::Engineer).await);
    let job = post(&app, &key, "/v1/jobs", &json!({"name": "wheel"})).await.header("location").to_owned();
    let spec = crate::jobs::streams::spec();
    let stream = post(&app, &key, &format!("{job}/streams"), &spec).await.header("location").to_owned();
    let mut listener = Listener::of(app.get(&format!("{job}/events")).bearer_auth(&key), None).await.unwrap();
    assert!(listener.next().await.is_some(), "the stream was opened");
    let mut socket = socket::connect_with(&format!("http://{}", app.address), &stream, &key).await;
    let revoked = Instant::now();
    let place = format!("/v1/keys/{}", &key[4..20]);
    assert_eq!(send(request(&app, &admin, Method::DELETE, &place, &json!({}))).await.status, 204);
    assert_eq!(socket::close(&mut socket).await.map(u16::from), Some(1008));
    assert!(listener.next().await.is_none());
    assert!(revoked.elapsed() < Duration::from_secs(30), "{:?}", revoked.elapsed());
    app.stop().await;
}

/// The time of a key's last use is known to the minute.
#[tokio::test]
async fn the_last_use_is_written_down() {
    let app = start().await;
    let admin = key_of(&app, "default", Role::Admin).await;
    let place = format!("/v1/keys/{}", &admin[4..20]);
    assert!(get(&app, &admin, &place).await.json().get("last_used_at").is_none());
    let used = SystemClock.now();
    let last = loop {
        let now = get(&app, &admin, &place).await.json();
        if let Some(last) = now["last_used_at"].as_str() {
            break last.parse::<Timestamp>().unwrap();
        }
        assert!(used.duration_until(SystemClock.now()) < SignedDuration::from_secs(60), "{now}");
        tokio::time::sleep(Duration::from_millis(500)).await;
    };
    assert!(last.duration_since(used).abs() < SignedDuration::from_secs(60));
    app.stop().await;
}

/// The first key is made on the database and written alone on its line.
#[tokio::test]
async fn the_first_key_is_made_on_the_database() {
    let folder = tempfile::tempdir().unwrap();
    let url = crate::database::in_file(&folder.path().join("test.db"));
    let create = |more: &[&str]| {
        let (code, key, said) = program(&[&["keys", "create", "--database-url", &url], more].concat(), &[]);
        (code == Some(0), key, said)
    };
    let (done, key, said) = create(&["--tenant", "plant-7", "--role", "admin"]);
    assert!(done && key.len() == 94 && key.starts_with("ffk_") && key.ends_with('\n'), "{key}{said}");
    assert!(!said.contains(&key[21..85]));
    let (done, root, said) = create(&["--role", "root"]);
    assert!(done, "{said}");
    for (wrong, why) in [
        (&["--role", "admin"][..], "--tenant"),
        (&["--role", "root", "--tenant", "plant-7"], "leave --tenant out"),
        (&["--role", "god", "--tenant", "plant-7"], "reader, operator"),
        (&["--role", "admin", "--tenant", "Plant 7"], "lower-case"),
    ] {
        let (done, out, said) = create(wrong);
        assert!(!done && out.is_empty() && said.contains(why), "{said}");
    }
    let app = TestApp::start_in(folder, |settings| {
        settings.auth = Authentication::Auto;
        settings.database_url.clone_from(&url);
    })
    .await;
    assert_eq!(get(&app, key.trim(), "/v1/whoami").await.json()["tenant"], "plant-7");
    assert_eq!(get(&app, root.trim(), "/v1/tenants/plant-7").await.json()["suspended"], false);
    let entered = get(&app, key.trim(), "/v1/audit").await.json();
    assert_eq!(
        (&entered["items"][0]["actor"], &entered["items"][0]["action"], entered["items"].as_array().unwrap().len()),
        (&"keys create".into(), &"tenant.create".into(), 1)
    );
    app.fit(CURVE).await.problem(401, "unauthorized");
    // a server has the file open
    let (done, _, said) = create(&["--tenant", "plant-7", "--role", "admin"]);
    assert!(!done && said.contains("in use"), "{said}");
    app.stop().await;
}

/// Nobody can lock the tenant out, and nobody can revoke a key that they could not grant.
#[tokio::test]
async fn the_last_administrator_stays_and_is_not_revoked_from_below() {
    let app = start().await;
    let (first, second) = (key_of(&app, "default", Role::Admin).await, key_of(&app, "default", Role::Admin).await);
    let place = |key: &str| format!("/v1/keys/{}", &key[4..20]);
    let revoke = async |by: &str, key: &str| send(request(&app, by, Method::DELETE, &place(key), &json!({}))).await;
    let made = post(&app, &first, "/v1/keys", &json!({"name": "keys alone", "scopes": ["admin"]})).await;
    let below = text(&made.json()["key"]);
    revoke(&below, &first).await.problem(403, "forbidden");
    // such a key cannot create archives either, since they contain data it may not read
    let engineer = key_of(&app, "default", Role::Engineer).await;
    let job = post(&app, &engineer, "/v1/jobs", &json!({"name": "wheel"})).await.header("location").to_owned();
    get(&app, &below, &format!("{job}/archive")).await.problem(403, "forbidden");
    assert_eq!(revoke(&first, &below).await.status, 204);
    assert_eq!(revoke(&second, &second).await.status, 204, "there is another one");
    revoke(&first, &first).await.problem(409, "conflict");
    assert_eq!(get(&app, &first, "/v1/whoami").await.status, 200);
    app.stop().await;
}
